// SPDX-License-Identifier: MIT OR Apache-2.0
//! What runs over the slices of a volume: a number of the Fresnel term, or of the distribution, at every position of the
//! third axis.

use std::fmt;

use crate::axis::Points;
use crate::error::{Error, Result};
use crate::term::fresnel::film::FILM_NM;
use crate::term::fresnel::{Fresnel, IOR_RANGE};

/// Which number a slice stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// The refractive index behind a surface over that before it.
    Ior,
    /// The exponent of a generalised Schlick term.
    Exponent,
    /// The thickness of a thin film.
    FilmNm,
    /// The reflectance at normal incidence of Schlick's term.
    F0,
    /// The azimuth between the view and the wide axis of an anisotropic lobe.
    Azimuth,
}

impl Kind {
    /// What a number of it is called in files and messages.
    pub fn name(self) -> &'static str {
        match self {
            Kind::Ior => "index",
            Kind::Exponent => "exponent",
            Kind::FilmNm => "thickness in nm",
            Kind::F0 => "F0",
            Kind::Azimuth => "azimuth in degrees",
        }
    }

    /// The same in the plural, for messages.
    pub fn about(self) -> &'static str {
        match self {
            Kind::Ior => "refractive indices",
            Kind::Exponent => "exponents",
            Kind::FilmNm => "film thicknesses",
            Kind::F0 => "F0",
            Kind::Azimuth => "azimuths",
        }
    }

    /// What a file says beside the ends of the axis.
    pub(super) fn note(self) -> &'static str {
        match self {
            Kind::Ior => "; an index of 1 is no interface",
            Kind::Exponent | Kind::FilmNm | Kind::F0 | Kind::Azimuth => "",
        }
    }

    /// What a file says of a term whose number runs over the slices: the rest of it.
    pub(super) fn term(self, fresnel: &Fresnel) -> String {
        match self {
            Kind::Ior => "dielectric".into(),
            Kind::Exponent => "power".into(),
            Kind::FilmNm => fresnel.with_film_nm(0.0).to_string(),
            Kind::F0 => "f0".into(),
            Kind::Azimuth => fresnel.to_string(),
        }
    }
}

/// Which number lies at a position along the third axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SliceAxis {
    /// Evenly from one refractive index to another, both on the same side of 1, or 1.
    Ior([f64; 2]),
    /// index = (1 + t²)/(1 − t²), so that F0 = t⁴; t is at most 0.99 (Blender Cycles).
    FromF0,
    /// One over that: the same interfaces from inside.
    InverseFromF0,
    /// From 1/2.5 to 1 in the first half, evenly in one over the index, and evenly from 1 to 2.5 in the second (OpenPBR).
    Openpbr,
    /// exponent = 5 (1 − t)/t, infinite at 0; t is at most 0.99 (Blender Cycles).
    CyclesExponent,
    /// Evenly from one thickness in nm to another.
    FilmNm([f64; 2]),
    /// Evenly from one F0 to another.
    F0([f64; 2]),
    /// Evenly from one azimuth in degrees to another.
    Azimuth([f64; 2]),
}

/// Names of the maps without numbers.
const NAMES: [(&str, SliceAxis); 4] = [
    ("ior_from_f0", SliceAxis::FromF0),
    ("inverse_ior_from_f0", SliceAxis::InverseFromF0),
    ("openpbr_ior", SliceAxis::Openpbr),
    ("cycles_exponent", SliceAxis::CyclesExponent),
];
const MOST_OF_CYCLES: f64 = 0.99;
const MOST_OF_OPENPBR: f64 = 2.5;

/// An axis that runs evenly from one number to another.
struct Linear {
    /// What its name begins with.
    prefix: &'static str,
    /// Least and greatest number.
    range: [f64; 2],
    /// What both numbers must be.
    rule: &'static str,
    /// Whether they are, beside the range.
    fits: fn(from: f64, to: f64) -> bool,
    axis: fn([f64; 2]) -> SliceAxis,
}

static LINEAR: [Linear; 4] = [
    Linear {
        prefix: "ior=",
        range: IOR_RANGE,
        rule: "indices, both at least 1 or both at most 1",
        fits: |from, to| (from - 1.0) * (to - 1.0) >= 0.0,
        axis: SliceAxis::Ior,
    },
    Linear {
        prefix: "film_nm=",
        range: FILM_NM,
        rule: "thicknesses in nm",
        fits: |_, _| true,
        axis: SliceAxis::FilmNm,
    },
    Linear { prefix: "f0=", range: [0.0, 1.0], rule: "reflectances", fits: |_, _| true, axis: SliceAxis::F0 },
    Linear { prefix: "azimuth=", range: [0.0, 90.0], rule: "degrees", fits: |_, _| true, axis: SliceAxis::Azimuth },
];

impl SliceAxis {
    /// The axis that a name means; `None` for the name of an axis within a slice.
    pub fn parse(name: &str) -> Option<Result<SliceAxis>> {
        if let Some((_, axis)) = NAMES.iter().find(|(n, _)| *n == name) {
            return Some(Ok(*axis));
        }
        let linear = LINEAR.iter().find(|linear| name.starts_with(linear.prefix))?;
        let Linear { prefix, range: [least, most], rule, .. } = linear;
        let numbers = name[prefix.len()..].split('/');
        let numbers: Option<Vec<f64>> =
            numbers.map(|n| n.parse::<f64>().ok().filter(|n| (*least..=*most).contains(n))).collect();
        Some(match numbers.as_deref() {
            Some([from, to]) if from != to && (linear.fits)(*from, *to) => Ok((linear.axis)([*from, *to])),
            _ => Err(Error::usage(
                format!("'{name}' is no axis over slices"),
                format!("write {prefix}FROM/TO with two different {rule}, from {least} to {most}"),
            )),
        })
    }

    /// Which number runs along it.
    pub fn kind(self) -> Kind {
        match self {
            SliceAxis::Ior(_) | SliceAxis::FromF0 | SliceAxis::InverseFromF0 | SliceAxis::Openpbr => Kind::Ior,
            SliceAxis::CyclesExponent => Kind::Exponent,
            SliceAxis::FilmNm(_) => Kind::FilmNm,
            SliceAxis::F0(_) => Kind::F0,
            SliceAxis::Azimuth(_) => Kind::Azimuth,
        }
    }

    /// The number of slice `i` of `len`.
    pub fn value(self, i: u32, len: u32, points: Points) -> f64 {
        let position = |i: u32, len: u32| match points {
            Points::Centers => (f64::from(i) + 0.5) / f64::from(len),
            Points::Edges => f64::from(i) / f64::from(len - 1),
        };
        match self {
            SliceAxis::Ior([from, to])
            | SliceAxis::FilmNm([from, to])
            | SliceAxis::F0([from, to])
            | SliceAxis::Azimuth([from, to]) => from + (to - from) * position(i, len),
            SliceAxis::FromF0 => {
                let f0_root = position(i, len).min(MOST_OF_CYCLES).powi(2);
                (1.0 + f0_root) / (1.0 - f0_root)
            }
            SliceAxis::InverseFromF0 => 1.0 / SliceAxis::FromF0.value(i, len, points),
            SliceAxis::CyclesExponent => {
                let t = position(i, len).min(MOST_OF_CYCLES);
                5.0 * (1.0 - t) / t
            }
            SliceAxis::Openpbr => {
                let half = len / 2;
                let above = |i: u32| 1.0 + (MOST_OF_OPENPBR - 1.0) * position(i, half);
                if i < half { 1.0 / above(half - 1 - i) } else { above(i - half) }
            }
        }
    }
}

/// The name of the axis, which [`SliceAxis::parse`] reads back.
impl fmt::Display for SliceAxis {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            SliceAxis::Ior([from, to]) => write!(f, "ior={from}/{to}"),
            SliceAxis::FilmNm([from, to]) => write!(f, "film_nm={from}/{to}"),
            SliceAxis::F0([from, to]) => write!(f, "f0={from}/{to}"),
            SliceAxis::Azimuth([from, to]) => write!(f, "azimuth={from}/{to}"),
            named => f.write_str(NAMES.iter().find(|(_, axis)| axis == named).map_or("", |(name, _)| name)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_reach_their_ends_and_are_read_back() {
        let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-12, "{a} instead of {b}");
        let (edges, n) = (Points::Edges, 16);
        near(SliceAxis::FromF0.value(0, n, edges), 1.0);
        // t = 10/15: F0 = t⁴.
        let ior = SliceAxis::FromF0.value(10, n, edges);
        near(((ior - 1.0) / (ior + 1.0)).powi(2), (2.0f64 / 3.0).powi(4));
        near(SliceAxis::FromF0.value(15, n, edges), (1.0 + 0.9801) / (1.0 - 0.9801));
        near(SliceAxis::InverseFromF0.value(10, n, edges) * ior, 1.0);
        for (i, expected) in [(0, 0.4), (15, 1.0), (16, 1.0), (31, 2.5), (1, 1.0 / 2.4), (17, 1.1)] {
            near(SliceAxis::Openpbr.value(i, 32, edges), expected);
        }
        // Half-way lies Schlick's own exponent.
        near(SliceAxis::CyclesExponent.value(1, 3, edges), 5.0);
        assert_eq!(SliceAxis::CyclesExponent.value(0, 3, edges), f64::INFINITY);
        let linear = SliceAxis::Ior([1.1, 2.1]);
        near(linear.value(0, 4, edges), 1.1);
        near(linear.value(0, 4, Points::Centers), 1.225);
        near(SliceAxis::FilmNm([100.0, 500.0]).value(1, 3, edges), 300.0);
        for axis in
            [linear, SliceAxis::FilmNm([0.0, 1200.0]), SliceAxis::F0([0.0, 1.0]), SliceAxis::Azimuth([0.0, 90.0])]
                .into_iter()
                .chain(NAMES.map(|(_, axis)| axis))
        {
            assert_eq!(SliceAxis::parse(&axis.to_string()).expect("over slices").expect("its own name"), axis);
        }
        assert!(SliceAxis::parse("roughness").is_none());
        for bad in [
            "ior=",
            "ior=1.5",
            "ior=0.5/2",
            "ior=1.5/1.5",
            "ior=1.5/x",
            "ior=1.5/9",
            "film_nm=-1/9",
            "f0=0/2",
            "azimuth=0/91",
        ] {
            assert!(SliceAxis::parse(bad).expect("over slices").is_err(), "{bad}");
        }
    }
}
