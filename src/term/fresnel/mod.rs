// SPDX-License-Identifier: MIT OR Apache-2.0
//! Fresnel terms, one file each; the GLSL twin of `term/fresnel/x.rs` is `shaders/term/fresnel/x.glsl`. Terms that only the
//! ring rule ([`crate::rule::rings`]) takes live in Rust alone: there the host evaluates them.
//!
//! A bake integrates the BRDF with F replaced by up to four *weights* at once, functions of v·h alone. The first weight is
//! always 1, so that the first integral is the directional albedo with F = 1; the others are what the term splits
//! reflectance into.

pub mod conductor;
pub mod dielectric;
pub mod film;
pub mod internal;
pub mod one;
pub mod power;
pub mod rescaled;
pub mod schlick;

use std::fmt;

use crate::error::{Error, Result};

/// Weights that a bake integrates at once.
pub const WEIGHTS: usize = 4;

/// Values of the weights, or integrals over them.
pub type Weights = [f64; WEIGHTS];

/// A Fresnel term.
pub struct Term {
    /// The name used in files.
    pub name: &'static str,
    /// One line for lists.
    pub about: &'static str,
    /// Paper and equation.
    pub source: &'static str,
    /// Stem of its two files; `None` where no shader evaluates it.
    pub file: Option<&'static str>,
    /// The weights at cosine v·h in [0, 1].
    pub weights: fn(v_dot_h: f64, optics: &Optics) -> Weights,
    /// Cosine v·h at which they are not smooth; an integration splits there.
    pub kink: Option<fn(optics: &Optics) -> f64>,
    /// Azimuth nodes a panel of the h-split rule, crowded at the panel's end, where the geometry term's will not do; the
    /// GLSL twin says the same as `FRESNEL_AZIMUTH_NODES`.
    pub azimuth: Option<usize>,
    /// Cosines v·h at which the panels of the ring rule end, for a term that no shader evaluates: where the weights have a
    /// kink, or change within less than a panel.
    pub breaks: Option<fn(optics: &Optics) -> Vec<f64>>,
}

/// Optical constants of what is below the surface, relative to what is above it, for red, green and blue.
/// GLSL twin: `shaders/lib/optics.glsl`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Optics {
    /// Refractive index; a dielectric has one, the first.
    pub eta: [f64; 3],
    /// Extinction coefficient, for conductors.
    pub k: [f64; 3],
    /// What else a term needs: Schlick's F0 where it is given, an exponent, an index that is rescaled, index and thickness in nm of a film. No shader reads it.
    pub given: [f64; 2],
}

/// A Fresnel term with the optical constants that it needs.
#[derive(Clone, Copy)]
pub struct Fresnel {
    /// The term.
    pub term: &'static Term,
    /// Its constants; all 0 where it needs none.
    pub optics: Optics,
}

/// Every Fresnel term, in the order of their documentation.
pub static TERMS: &[&Term] = &[
    &one::ONE,
    &schlick::SCHLICK,
    &dielectric::DIELECTRIC,
    &internal::INTERNAL,
    &conductor::CONDUCTOR,
    &power::POWER,
    &rescaled::RESCALED,
    &film::FILM,
];

impl Optics {
    /// Those of a term that needs none.
    pub const NONE: Optics = Optics { eta: [0.0; 3], k: [0.0; 3], given: [0.0; 2] };
}

/// Refractive indices, relative to the other side, that are baked.
pub const IOR_RANGE: [f64; 2] = [0.2, 5.0];

impl Fresnel {
    /// F = 1.
    pub const ONE: Fresnel = Fresnel { term: &one::ONE, optics: Optics::NONE };
    /// Schlick's split.
    pub const SCHLICK: Fresnel = Fresnel { term: &schlick::SCHLICK, optics: Optics::NONE };

    /// Schlick's term of common glass.
    pub const GLASS: Fresnel =
        Fresnel { term: &schlick::SCHLICK, optics: Optics { given: [0.04, 0.0], ..Optics::NONE } };

    /// Schlick's term at a reflectance at normal incidence.
    pub fn schlick(f0: f64) -> Result<Fresnel> {
        if !(0.0..=1.0).contains(&f0) {
            return Err(Error::usage(format!("an F0 of {f0} is no reflectance"), "give a number from 0 to 1"));
        }
        Ok(Fresnel { optics: Optics { given: [f0, 0.0], ..Optics::NONE }, ..Fresnel::SCHLICK })
    }

    /// F0 of Schlick's term; 0 where a shader completes the split.
    pub fn f0(&self) -> f64 {
        if std::ptr::eq(self.term, &schlick::SCHLICK) { self.optics.given[0] } else { 0.0 }
    }

    /// A dielectric of refractive index `ior` over the index of the medium that light comes from: above 1 seen from
    /// outside, below 1 from inside.
    pub fn dielectric(ior: f64) -> Result<Fresnel> {
        let [least, most] = IOR_RANGE;
        if !(least..=most).contains(&ior) || ior == 1.0 {
            return Err(Error::usage(
                format!("a refractive index of {ior} cannot be baked"),
                format!("give a number from {least} to {most} other than 1; below 1 is light that comes from inside"),
            ));
        }
        Ok(Fresnel::interface(ior))
    }

    /// A dielectric interface of any index, 1 for none included.
    pub fn interface(ior: f64) -> Fresnel {
        let term = if ior < 1.0 { &internal::INTERNAL } else { &dielectric::DIELECTRIC };
        Fresnel { term, optics: Optics { eta: [ior; 3], ..Optics::NONE } }
    }

    /// A conductor of refractive index `eta` and extinction coefficient `k` for red, green and blue.
    pub fn conductor(eta: [f64; 3], k: [f64; 3]) -> Result<Fresnel> {
        let bad = |x: &&f64| !(0.0..=100.0).contains(*x);
        if let Some(bad) = eta.iter().chain(&k).find(bad) {
            return Err(Error::usage(
                format!("{bad} is not a refractive index or extinction coefficient that can be baked"),
                "give numbers from 0 to 100",
            ));
        }
        if eta.iter().zip(&k).any(|(eta, k)| *eta <= 1.0 && *k < 0.01) {
            return Err(Error::usage(
                "a conductor with eta up to 1 and no extinction would reflect like the inside of a dielectric",
                "give its k, or bake a dielectric with --ior",
            ));
        }
        Ok(Fresnel { term: &conductor::CONDUCTOR, optics: Optics { eta, k, ..Optics::NONE } })
    }

    /// The weight of F90 in a generalised Schlick term, (1 − v·h) to this power; infinite for none.
    pub fn power(exponent: f64) -> Result<Fresnel> {
        if exponent.is_nan() || exponent < 0.01 {
            return Err(Error::usage(
                format!("an exponent of {exponent} cannot be baked"),
                "give a number of at least 0.01; Schlick's own is 5",
            ));
        }
        Ok(Fresnel { term: &power::POWER, optics: Optics { given: [exponent, 0.0], ..Optics::NONE } })
    }

    /// The same weight from the exact reflectance of a dielectric of refractive index `ior`, at least 1.
    pub fn rescaled(ior: f64) -> Result<Fresnel> {
        if !(1.0..=1000.0).contains(&ior) {
            return Err(Error::usage(
                format!("the reflectance of a refractive index of {ior} cannot be rescaled"),
                "give an index from 1 to 1000, as seen from outside",
            ));
        }
        Ok(Fresnel { term: &rescaled::RESCALED, optics: Optics { given: [ior, 0.0], ..Optics::NONE } })
    }

    /// A film of refractive index `ior` and a thickness in nm on a base that this is the term of: a dielectric from outside, or
    /// none ([`Fresnel::interface`] of 1: a bubble), or a conductor.
    pub fn film(base: Fresnel, ior: f64, nm: f64) -> Result<Fresnel> {
        if !["dielectric", "conductor"].contains(&base.term.name) {
            return Err(Error::usage(
                format!("a film lies on a dielectric or a metal, not on the Fresnel term '{base}'"),
                "give its base with --ior of at least 1, --eta-k or --material",
            ));
        }
        Fresnel::on_base(base.optics.eta, base.optics.k, ior, nm)
    }

    fn on_base(eta: [f64; 3], k: [f64; 3], ior: f64, nm: f64) -> Result<Fresnel> {
        let [least, most] = film::FILM_IOR;
        if !(least..=most).contains(&ior) {
            return Err(Error::usage(
                format!("a film of refractive index {ior} cannot be baked"),
                format!("give a number from {least} to {most}"),
            ));
        }
        let [least, most] = film::FILM_NM;
        if !(least..=most).contains(&nm) {
            return Err(Error::usage(
                format!("a film of {nm} nm cannot be baked"),
                format!("give a thickness from {least} to {most} nm; beyond, interference has no colour left"),
            ));
        }
        Ok(Fresnel { term: &film::FILM, optics: Optics { eta, k, given: [ior, nm] } })
    }

    /// The term that its canonical text, as [`fmt::Display`] writes it, describes.
    pub fn parse(text: &str) -> Result<Fresnel> {
        let bad = || Error::usage(format!("unknown Fresnel term '{text}'"), "see `brdf-baker list fresnels`");
        let (name, list) = text.split_once(':').unwrap_or((text, ""));
        let numbers = |key: &str| -> Result<Vec<f64>> {
            let found = list.split(',').find_map(|pair| pair.strip_prefix(key)?.strip_prefix('='));
            found.ok_or_else(bad)?.split('/').map(|n| n.parse().map_err(|_| bad())).collect()
        };
        let three = |key: &str| -> Result<[f64; 3]> { numbers(key)?.try_into().map_err(|_| bad()) };
        match name {
            "one" if list.is_empty() => Ok(Fresnel::ONE),
            "schlick" if list.is_empty() => Ok(Fresnel::SCHLICK),
            "schlick" => Fresnel::schlick(*numbers("f0")?.first().ok_or_else(bad)?),
            "dielectric" => Fresnel::dielectric(*numbers("ior")?.first().ok_or_else(bad)?),
            "conductor" => Fresnel::conductor(three("eta")?, three("k")?),
            "power" => Fresnel::power(*numbers("exponent")?.first().ok_or_else(bad)?),
            "rescaled" => Fresnel::rescaled(*numbers("ior")?.first().ok_or_else(bad)?),
            "film" => {
                let one = |key: &str| numbers(key)?.first().copied().ok_or_else(bad);
                Fresnel::on_base(three("eta")?, three("k")?, one("ior")?, one("nm")?)
            }
            _ => Err(bad()),
        }
    }

    /// It is that of a given material, not a split that a shader completes.
    pub fn is_exact(&self) -> bool {
        self.optics.eta[0] != 0.0
    }

    /// The same with a film of another thickness.
    pub(crate) fn with_film_nm(self, nm: f64) -> Fresnel {
        let [ior, _] = self.optics.given;
        Fresnel { optics: Optics { given: [ior, nm], ..self.optics }, ..self }
    }

    /// The weights at cosine v·h.
    pub fn weights(&self, v_dot_h: f64) -> Weights {
        (self.term.weights)(v_dot_h, &self.optics)
    }

    /// Cosine v·h at which the weights are not smooth.
    pub fn kink(&self) -> Option<f64> {
        self.term.kink.map(|kink| kink(&self.optics))
    }

    /// Cosines v·h at which the panels of the ring rule end.
    pub fn breaks(&self) -> Vec<f64> {
        self.term.breaks.map_or(vec![], |breaks| breaks(&self.optics))
    }
}

/// The canonical text, which [`Fresnel::parse`] reads back.
impl fmt::Display for Fresnel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Optics { eta, k, given } = self.optics;
        let list = |x: [f64; 3]| x.map(|x| x.to_string()).join("/");
        match self.term.name {
            // Outside and inside are one term to a user: the index tells them apart.
            "dielectric" | "internal" => write!(f, "dielectric:ior={}", eta[0]),
            "conductor" => write!(f, "conductor:eta={},k={}", list(eta), list(k)),
            "schlick" if given[0] != 0.0 => write!(f, "schlick:f0={}", given[0]),
            "film" => write!(f, "film:ior={},nm={},eta={},k={}", given[0], given[1], list(eta), list(k)),
            "power" => write!(f, "power:exponent={}", given[0]),
            "rescaled" => write!(f, "rescaled:ior={}", given[0]),
            name => f.write_str(name),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const EVERY: [&str; 10] = [
        "one",
        "schlick",
        "dielectric:ior=1.5",
        "dielectric:ior=0.5",
        "conductor:eta=0.2/1/1.5,k=3/2.5/2",
        "schlick:f0=0.04",
        "power:exponent=0.5",
        "power:exponent=inf",
        "rescaled:ior=1.5",
        "film:ior=1.33,nm=400,eta=1.5/1.5/1.5,k=0/0/0",
    ];

    #[test]
    fn text_is_parsed_and_printed_canonically() {
        for text in EVERY {
            assert_eq!(Fresnel::parse(text).unwrap().to_string(), text);
        }
        for text in
            ["", "schlick:ior=1", "dielectric", "dielectric:ior=1", "dielectric:ior=x", "conductor:eta=1,k=2", "power"]
        {
            assert!(Fresnel::parse(text).is_err(), "{text}");
        }
    }

    #[test]
    fn first_weight_is_one() {
        for text in EVERY {
            let fresnel = Fresnel::parse(text).unwrap();
            for c in [0.0, 0.3, 1.0] {
                assert_eq!(fresnel.weights(c)[0], 1.0, "{text}");
            }
        }
    }

    #[test]
    fn transparent_conductor_is_a_dielectric() {
        for c in [0.0, 0.01, 0.2, 0.7, 1.0] {
            for eta in [1.1, 1.5, 2.4] {
                let (a, b) = (conductor::conductor(c, eta, 0.0), dielectric::dielectric(c, eta));
                assert!((a - b).abs() < 1e-14, "{c} {eta}: {a} and {b}");
            }
        }
    }

    #[test]
    fn reflectance_has_its_known_values() {
        // Normal incidence, grazing, and Brewster's angle, where only the s-polarised half is left.
        let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-14, "{a} instead of {b}");
        near(dielectric::dielectric(1.0, 1.5), 0.04);
        near(dielectric::dielectric(0.0, 1.5), 1.0);
        let brewster = 1.5f64.atan().cos();
        let s = ((1.0 - 1.5f64 * 1.5) / (1.0 + 1.5 * 1.5)).powi(2);
        near(dielectric::dielectric(brewster, 1.5), 0.5 * s);
        near(conductor::conductor(0.0, 0.2, 3.9), 1.0);
        near(conductor::conductor(1.0, 0.2, 3.9), (0.8 * 0.8 + 3.9 * 3.9) / (1.2 * 1.2 + 3.9 * 3.9));
        // Snell's law seen from the other side: the same reflectance at the refracted angle.
        for c in [0.1f64, 0.5, 0.9] {
            let inside = (1.0 - (1.0 - c * c) / (1.5 * 1.5)).sqrt();
            let a = dielectric::dielectric(c, 1.5);
            let b = internal::internal(inside, 1.0 / 1.5);
            assert!((a - b).abs() < 1e-12, "{c}: {a} and {b}");
        }
        near(internal::internal(0.7, 1.0 / 1.5), 1.0);
    }
}
