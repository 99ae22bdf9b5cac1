// SPDX-License-Identifier: MIT OR Apache-2.0
//! How engines shade image-based light, read in their shaders.

use super::Point;
use crate::error::{Error, Result, nearest};
use crate::ndf::alpha_of;

/// What an engine does between its maps and a pixel.
pub struct Formula {
    /// Name.
    pub name: &'static str,
    /// Where it was read.
    pub source: &'static str,
    /// The perceptual roughness at which maps and table are read, from the material's.
    pub roughness: fn(roughness: f64, point: &Point) -> f64,
    /// The direction, of any length, in which the reflected light is read, at the roughness of [`Formula::roughness`].
    pub direction: fn(point: &Point, roughness: f64) -> [f64; 3],
    /// The mip that holds a roughness, as a share of the last one.
    pub level: fn(roughness: f64) -> f64,
    /// By what the reflected light and the irradiance over π are multiplied.
    pub shares: fn(&Surface) -> [f64; 2],
}

/// What a channel's shares depend on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Surface {
    /// Reflectance at normal incidence.
    pub f0: f64,
    /// Albedo of what lies under the surface, 0 where nothing does.
    pub albedo: f64,
    /// Scale of the split sum.
    pub scale: f64,
    /// Bias of the split sum.
    pub bias: f64,
    /// Cosine between normal and view.
    pub n_dot_v: f64,
    /// Perceptual roughness.
    pub roughness: f64,
}

/// All of them.
pub static FORMULAS: &[Formula] = &[
    Formula {
        name: "three",
        source: "three.js r187: lights_physical_fragment, envmap_physical_pars_fragment, lights_physical_pars_fragment",
        // Filament's least roughness, and what the curvature of the surface adds.
        roughness: |roughness, point| (roughness.max(0.045) + point.n_step).min(1.0),
        direction: |point, roughness| towards_normal(point, roughness.powi(4)),
        level: |roughness| roughness * (2.0 - roughness),
        shares: fdez_aguera,
    },
    Formula {
        name: "bevy",
        source: "Bevy 0.19: bevy_pbr, environment_map.wgsl and pbr_lighting.wgsl",
        roughness: |roughness, _| roughness,
        direction: |point, roughness| {
            let alpha = alpha_of(roughness.max(0.089));
            let smoothness = 1.0 - alpha;
            towards_normal(point, 1.0 - smoothness * (smoothness.sqrt() + alpha))
        },
        level: |roughness| roughness,
        shares: fdez_aguera,
    },
    Formula {
        name: "gltf",
        source: "Khronos glTF Sample Renderer 1.1: pbr.frag, ibl.glsl",
        roughness: |roughness, _| roughness,
        direction: |point, _| point.r(),
        level: |roughness| roughness,
        shares: fdez_aguera_rough,
    },
    Formula {
        name: "materialx",
        source: "MaterialX 1.39: mx_environment_prefilter.glsl, mx_generalized_schlick_bsdf.glsl, mx_microfacet_specular.glsl",
        roughness: |roughness, _| roughness,
        direction: |point, _| point.r(),
        // The roughest mip is not the last one.
        level: |roughness| if roughness < 0.5 { roughness } else { 0.5 * alpha_of(roughness) + 0.375 },
        shares: turquin,
    },
];

impl Formula {
    /// The roughness of mip `m`, of those up to `last`: the inverse of [`Formula::level`].
    pub fn roughness_of(&self, m: u32, last: u32) -> f64 {
        let share = f64::from(m) / f64::from(last.max(1));
        let (mut low, mut high) = (0.0, 1.0);
        while high - low > 1e-14 {
            let middle = 0.5 * (low + high);
            if (self.level)(middle) < share { low = middle } else { high = middle }
        }
        if m >= last {
            1.0
        } else if m == 0 {
            0.0
        } else {
            low
        }
    }

    /// The formula with this name.
    pub fn parse(name: &str) -> Result<&'static Formula> {
        FORMULAS.iter().find(|f| f.name == name).ok_or_else(|| {
            Error::usage(format!("unknown formula '{name}'"), nearest(name, FORMULAS.iter().map(|f| f.name)))
        })
    }
}

/// The mirrored view, pulled towards the normal by `share`: rough surfaces see less of what is at their horizon.
fn towards_normal(point: &Point, share: f64) -> [f64; 3] {
    let r = point.r();
    std::array::from_fn(|i| r[i] + share * (point.n[i] - r[i]))
}

/// Fdez-Agüera 2019, A Multiple-Scattering Microfacet Model for Real-Time Image-based Lighting: what is not reflected at
/// the first bounce goes on as diffuse light, and what leaves in either way does not reach the body below.
fn fdez_aguera(surface: &Surface) -> [f64; 2] {
    let single = surface.f0 * surface.scale + surface.bias;
    let multiple = bounces(single, surface);
    [single, multiple + surface.albedo * (1.0 - single - multiple)]
}

/// The same, but all bounces are read where the first one is, and the Fresnel term of the first loses with roughness what
/// it gains at grazing angles.
fn fdez_aguera_rough(surface: &Surface) -> [f64; 2] {
    let Surface { f0, albedo, scale, bias, n_dot_v, roughness } = *surface;
    let grazing = f0 + ((1.0 - roughness).max(f0) - f0) * (1.0 - n_dot_v).powi(5);
    let single = grazing * scale + bias;
    let reflected = single + bounces(single, surface);
    [reflected, albedo * (1.0 - reflected)]
}

/// What later bounces add to a `single` one.
fn bounces(single: f64, Surface { f0, scale, bias, .. }: &Surface) -> f64 {
    let lost = 1.0 - scale - bias;
    let average = f0 + (1.0 - f0) / 21.0;
    single * average / (1.0 - lost * average) * lost
}

/// Turquin 2019, Practical multiple scattering compensation for microfacet models, Eqs. 14 and 16, with Schlick's term.
fn turquin(Surface { f0, albedo, scale, bias, n_dot_v, .. }: &Surface) -> [f64; 2] {
    let whole = scale + bias;
    let fresnel = f0 + (1.0 - f0) * (1.0 - n_dot_v).powi(5);
    let reflected = (f0 * scale + bias) * (1.0 + fresnel * (1.0 - whole) / whole);
    [reflected, albedo * (1.0 - reflected)]
}
