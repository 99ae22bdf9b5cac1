// SPDX-License-Identifier: MIT OR Apache-2.0
//! The microfacet model that a table belongs to, and which rule computes it.

use std::cell::RefCell;

use super::{At, Tolerance};
use crate::error::{Error, Result};
use crate::ndf::{self, Given, Ndf, ggx};
use crate::rule::cone::mirror;
use crate::rule::cone_elliptic::{self, cone_elliptic};
use crate::rule::cone_nodes;
use crate::rule::h_split::{Outer, Row, h_split, outer};
use crate::rule::rings::{self, Ring, rings};
use crate::rule::transmit::{self, transmit};
use crate::term::fresnel::{Fresnel, Weights};
use crate::term::visibility::{self, Bounded, Visibility, smith};

/// D, G and F.
#[derive(Clone, Copy)]
pub struct Model {
    /// Distribution of normals.
    pub ndf: Ndf,
    /// Geometry term.
    pub visibility: &'static Visibility,
    /// Fresnel term.
    pub fresnel: Fresnel,
}

/// Which rule computes a model.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// [`crate::rule::cone`].
    Cone,
    /// [`crate::rule::cone_elliptic`].
    ConeElliptic,
    /// [`crate::rule::h_split`].
    HSplit,
    /// [`crate::rule::rings`].
    Rings,
    /// [`crate::rule::transmit`], of what is not reflected.
    Transmit,
}

/// Smith's masking alone, G = G1(v): what a sampler of visible normals sees of a facet before it looks where the light comes
/// from. No term of the registry, because it is not reciprocal; the ring rule knows it, and the truth takes it from here.
pub static MASKING: Visibility = Visibility {
    name: "masking",
    about: "Smith's masking of the viewer alone",
    source: "Heitz 2018, Sampling the GGX Distribution of Visible Normals, Eq. 2",
    file: "",
    g_over_n_dot_v: |d| 1.0 / d.sigma_v,
    ..smith::SMITH
};

/// A row and the model that it belongs to: neighbouring texels ask for the same one.
type LastRow = Option<(&'static str, Given, &'static str, f64, Row)>;

thread_local! {
    static LAST_ROW: RefCell<LastRow> = const { RefCell::new(None) };
    static NODES: RefCell<Vec<Outer>> = const { RefCell::new(vec![]) };
    static RINGS: RefCell<Vec<Ring>> = const { RefCell::new(vec![]) };
}

impl Model {
    /// The model with these names and Schlick's split; the distribution may have parameters, `NAME:parameter=value,…`.
    pub fn parse(ndf: &str, visibility: &str) -> Result<Model> {
        Ok(Model { ndf: ndf::parse(ndf)?, visibility: visibility::parse(visibility)?, fresnel: Fresnel::SCHLICK })
    }

    /// The same model with another Fresnel term.
    pub fn with(self, fresnel: Fresnel) -> Model {
        Model { fresnel, ..self }
    }

    /// Which rule computes it: GGX with smooth terms has faster ones of its own.
    pub fn method(&self) -> Method {
        if self.fresnel.term.file.is_none() {
            Method::Rings
        } else if self.is_anisotropic() {
            Method::ConeElliptic
        } else if self.is_ggx() && self.is_smooth() {
            Method::Cone
        } else {
            Method::HSplit
        }
    }

    fn is_ggx(&self) -> bool {
        std::ptr::eq(self.ndf.family, &ggx::GGX)
    }

    fn is_smooth(&self) -> bool {
        self.visibility.kinks.is_none() && self.fresnel.kink().is_none()
    }

    /// The lobe is not round.
    pub fn is_anisotropic(&self) -> bool {
        self.is_ggx() && self.ndf.lobe(1.0).is_some_and(|lobe| self.ndf.ellipse(&lobe).is_some())
    }

    /// Refuses what no rule computes.
    pub fn check(&self) -> Result<()> {
        let rings = self.is_ggx() && !self.is_anisotropic() && self.visibility.name == "smith";
        if self.method() == Method::Rings && !rings {
            return Err(Error::usage(
                format!(
                    "the Fresnel term '{}' is baked for ggx with smith, not for {} with {}",
                    self.fresnel.term.name, self.ndf, self.visibility.name
                ),
                "drop --ndf and --visibility",
            ));
        }
        if self.is_anisotropic() && !self.is_smooth() {
            let term = if self.visibility.kinks.is_some() { self.visibility.name } else { "internal reflection" };
            return Err(Error::usage(
                format!("an anisotropic lobe cannot be baked with {term}, which is not smooth"),
                "choose --visibility smith or smith-uncorrelated and a refractive index above 1",
            ));
        }
        Ok(())
    }

    /// The kernel that bakes it by a method, as [`crate::shaders::spirv`] knows it.
    pub fn kernel(&self, method: Method) -> String {
        let fresnel = self.fresnel.term.file.unwrap_or_default();
        let rule = match method {
            Method::Cone => "cone",
            Method::ConeElliptic => "cone_elliptic",
            Method::HSplit => "h_split",
            Method::Rings => return "bake/rings".into(),
            Method::Transmit => return format!("bake/transmit+{fresnel}"),
        };
        format!("bake/{rule}+{}+{fresnel}", self.visibility.file)
    }

    /// Does the geometry term count what the light does not reach? All do but masking alone.
    pub fn is_shadowed(&self) -> bool {
        self.visibility.name != MASKING.name
    }

    /// The rule's name and size, for certificates.
    pub fn rule_name(&self) -> String {
        match self.method() {
            Method::Rings => rings::rule_name(),
            Method::Transmit => transmit::rule_name(&self.fresnel),
            Method::Cone => {
                let (outer, inner) = (cone_nodes::OUTER, cone_nodes::INNER);
                format!("cone {outer}x{inner}, {} nodes", outer * inner)
            }
            Method::ConeElliptic => {
                let (outer, inner) = (cone_elliptic::OUTER, cone_nodes::INNER);
                format!("elliptic cone {outer}x{inner}, {} nodes", outer * inner)
            }
            Method::HSplit => {
                let azimuth = self.fresnel.term.azimuth.unwrap_or(self.visibility.azimuth);
                format!("h-split {}x{azimuth} a panel", self.visibility.outer)
            }
        }
    }

    /// The f64 rule: directional albedo with F replaced by each weight of the Fresnel term.
    pub fn rule(&self, at: At) -> Weights {
        if at.roughness == 0.0 && !self.ndf.is_fixed() {
            return mirror(at.n_dot_v, self.visibility.g_over_n_dot_v, |v_dot_h| self.fresnel.weights(v_dot_h));
        }
        match self.method() {
            Method::Cone => return (self.visibility.cone)(at.n_dot_v, ndf::alpha_of(at.roughness), &self.fresnel),
            Method::ConeElliptic => {
                if let Some(ellipse) = self.ndf.lobe(at.roughness).and_then(|lobe| self.ndf.ellipse(&lobe)) {
                    return cone_elliptic(ellipse, at.n_dot_v, self.visibility.g_over_n_dot_v, &self.fresnel);
                }
            }
            Method::Rings => {
                let alpha = ndf::alpha_of(at.roughness);
                return RINGS.with_borrow_mut(|list| {
                    list.clear();
                    rings::outer(alpha, at.n_dot_v, &self.fresnel, list);
                    rings(self.is_shadowed(), alpha, at.n_dot_v, &self.fresnel, list)
                });
            }
            Method::HSplit | Method::Transmit => {}
        }
        let row = self.row(at.roughness);
        NODES.with_borrow_mut(|nodes| {
            nodes.clear();
            outer(&self.ndf, self.visibility, &self.fresnel, &row, at.n_dot_v, nodes);
            h_split(self.visibility, &self.fresnel, &row, at.n_dot_v, nodes)
        })
    }

    /// The f64 rule of what a dielectric interface transmits. The model has a dielectric's Fresnel term and a Smith term.
    pub fn transmitted(&self, at: At) -> f64 {
        let row = self.row(at.roughness);
        if row.lobe.is_none() {
            return 1.0 - self.fresnel.weights(at.n_dot_v)[1];
        }
        NODES.with_borrow_mut(|nodes| {
            nodes.clear();
            transmit::outer(&self.ndf, &self.fresnel, &row, at.n_dot_v, nodes);
            transmit(self.visibility, &self.fresnel, &row, at.n_dot_v, nodes)
        })
    }

    /// The row of a roughness; the last one of each thread is kept.
    fn row(&self, roughness: f64) -> Row {
        LAST_ROW.with_borrow_mut(|last| match last {
            Some((family, given, visibility, of, row))
                if *family == self.ndf.family.name
                    && *given == self.ndf.given
                    && *visibility == self.visibility.name
                    && *of == roughness =>
            {
                *row
            }
            _ => {
                let row = Row::new(&self.ndf, self.visibility, roughness);
                *last = Some((self.ndf.family.name, self.ndf.given, self.visibility.name, roughness, row));
                row
            }
        })
    }

    /// Is the albedo with F = 1 at most 1, whatever the direction?
    pub fn bounded(&self) -> bool {
        match self.visibility.bounded {
            Bounded::Always => true,
            Bounded::Unless(families) => !families.contains(&self.ndf.family.name),
            Bounded::Never => false,
        }
    }

    /// The largest value that a texel may hold: what half floats can, where the albedo may exceed 1.
    pub fn largest(&self) -> f32 {
        if self.bounded() { 1.0 } else { 65504.0 }
    }

    /// What a user should know: why the model is not a physical one.
    pub fn note(&self) -> Option<String> {
        let mut notes: Vec<&str> = self.visibility.note.into_iter().collect();
        if self.visibility.note.is_none() && !self.bounded() {
            notes.push("this pair of distribution and geometry term does not conserve energy everywhere");
        }
        if self.ndf.is_fixed() {
            notes.push("the width of the distribution is given: every roughness holds the same values");
        }
        (!notes.is_empty()).then(|| notes.join("; "))
    }

    /// Refuses a limit that does not exist: at n·v = 0 if `at_grazing`, at roughness 0 if `at_mirror`.
    pub fn check_limits(&self, at_grazing: bool, at_mirror: bool) -> Result<()> {
        if at_grazing && self.visibility.diverges_at_grazing {
            return Err(Error::usage(
                format!(
                    "with visibility '{}' the albedo grows like 1/(n.v): at n.v = 0 it is infinite",
                    self.visibility.name
                ),
                "use --points centers",
            ));
        }
        if at_mirror && self.ndf.family.flat.falling && !self.ndf.is_fixed() {
            return Err(Error::usage(
                format!(
                    "'{}' has no limit at roughness 0: all of its facets would stand upright",
                    self.ndf.family.name
                ),
                "use --points centers",
            ));
        }
        Ok(())
    }

    /// The bounds of a table of this model; `cone` are those of the cone rule with Smith's terms.
    pub fn tolerance(&self, cone: &Tolerance) -> Tolerance {
        let method = self.method();
        if method == Method::Cone && self.visibility.smith {
            return *cone;
        }
        if method == Method::ConeElliptic {
            let why = "tests/truth.rs: ratio 0.04, 3e-5";
            return Tolerance { worst: 5e-5, median: 2e-6, near_zero: 1e-4, why };
        }
        let name = self.visibility.name;
        let standard = ["ggx", "beckmann", "blinn-phong"].contains(&self.ndf.family.name)
            && !["kelemen", "neubelt", "charlie", "beckmann-rational"].contains(&name);
        // Next to the critical angle a reflectance is as steep as a root.
        let steep = self.fresnel.kink().is_some();
        let worst = if (standard && !steep) || method == Method::Cone { 2e-6 } else { 2e-5 };
        Tolerance { worst, median: 0.25 * worst, near_zero: 2.0 * worst, why: "tests/truth.rs, tests/twins.rs" }
    }
}
