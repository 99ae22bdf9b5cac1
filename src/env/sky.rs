// SPDX-License-Identifier: MIT OR Apache-2.0
//! Analytic daylight: a clear sky, the sun's disc, and level ground that both light.
//!
//! **Sky.** Preetham, Shirley, Smits 1999, "A Practical Analytic Model for Daylight": a luminance and a chromaticity by
//! Perez' formula (their Eq. 3 and appendix A.2), fitted to simulated skies of turbidity 2 to 6 with the sun above the
//! horizon. 2 is very clear, 3 clear, 6 hazy, 10 nearly foggy.
//!
//! **Sun.** A black body at 5772 K (IAU 2015 resolution B3: 1361 W/m² above the air) of 0.53° across, dimmed by
//! Rayleigh's and Ångström's scattering along the optical path (the paper's appendix A.1), summed up over the spectrum for
//! the CIE 1931 observer. Ozone, mixed gases and water vapour, a few per cent of what is visible, are left out, and the disc
//! is as bright at its limb as in its middle.
//!
//! **Ground.** Below the horizon lies a Lambertian plane, albedo · E/π, with E from sky and sun, whether the disc is
//! drawn or not.
//!
//! Radiance is in kcd/m²: 0.2126 r + 0.7152 g + 0.0722 b is the luminance. +Y is up; the sun's azimuth is the picture's φ
//! ([`crate::env`]): 0° is +X, 90° is +Z.
//!
//! ```
//! use brdf_baker::env::sky::Sky;
//!
//! let daylight = Sky { turbidity: 2.5, sun_elevation_deg: 60.0, ..Sky::default() }.resolve()?;
//! let [r, _, b] = daylight.radiance([0.0, 1.0, 0.0]);
//! assert!(b > r, "the zenith is blue");
//! let picture = daylight.equirect(64);
//! assert_eq!((picture.width, picture.height), (128, 64));
//! # Ok::<(), brdf_baker::Error>(())
//! ```

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use rayon::prelude::*;

use super::Equirect;
use super::orientation::normalized;
use crate::error::{Error, Result};
use crate::material::observer;
use crate::quadrature::gauss_legendre::{Node, gauss_legendre};

/// Angle that the sun's disc takes up, in degrees: its mean over the year.
pub const SUN_DIAMETER_DEG: f64 = 0.53;
/// The sun's temperature as a black body, in kelvin: IAU 2015 resolution B3.
const SUN_TEMPERATURE_K: f64 = 5772.0;
/// Turbidities that the fit is asked for; below 2 its luminance turns dark at the horizon.
const TURBIDITY: [f64; 2] = [2.0, 10.0];

/// A day, as a user words it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sky {
    /// How hazy the air is, from 2 (very clear) to 10.
    pub turbidity: f64,
    /// Angle of the sun's centre above the horizon, from 0 to 90.
    pub sun_elevation_deg: f64,
    /// Azimuth of the sun from +X towards +Z.
    pub sun_azimuth_deg: f64,
    /// Is the sun's disc part of the picture?
    pub sun_disc: bool,
    /// Share of light that the ground reflects, red, green and blue, each in [0, 1].
    pub ground_albedo: [f64; 3],
}

impl Default for Sky {
    /// A clear afternoon: to a viewer who looks along −Z the sun stands behind, above the left shoulder.
    fn default() -> Self {
        Self {
            turbidity: 3.0,
            sun_elevation_deg: 40.0,
            sun_azimuth_deg: 125.0,
            sun_disc: false,
            ground_albedo: [0.2; 3],
        }
    }
}

/// A day made ready: radiance by direction.
#[derive(Clone, Debug)]
pub struct Daylight {
    /// What was asked for.
    pub sky: Sky,
    /// Unit vector towards the middle of the sun.
    pub sun: [f64; 3],
    /// Radiance of the sun's disc, kcd/m².
    pub sun_radiance: [f64; 3],
    /// Irradiance of level ground by the sky, klx.
    pub sky_irradiance: [f64; 3],
    /// Irradiance of level ground by the sun, klx.
    pub sun_irradiance: [f64; 3],
    /// Radiance of the ground, kcd/m².
    pub ground: [f64; 3],
    sun_theta: f64,
    sun_phi: f64,
    /// Y in kcd/m², x and y at the zenith.
    zenith: [f64; 3],
    /// Perez' A to E for Y, x and y.
    perez: [[f64; 5]; 3],
}

impl Sky {
    /// Checks every number.
    pub fn resolve(self) -> Result<Daylight> {
        let within = |what: &str, value: f64, [low, high]: [f64; 2]| {
            if (low..=high).contains(&value) {
                return Ok(());
            }
            Err(Error::usage(format!("{what} cannot be {value}"), format!("give a number from {low} to {high}")))
        };
        within("the turbidity", self.turbidity, TURBIDITY)?;
        within("the sun's elevation", self.sun_elevation_deg, [0.0, 90.0])?;
        within("the sun's azimuth", self.sun_azimuth_deg, [-360.0, 360.0])?;
        for albedo in self.ground_albedo {
            within("the ground's albedo", albedo, [0.0, 1.0])?;
        }
        Ok(Daylight::new(self))
    }
}

impl Daylight {
    fn new(sky: Sky) -> Daylight {
        let sun_theta = (90.0 - sky.sun_elevation_deg).to_radians();
        let sun_phi = sky.sun_azimuth_deg.to_radians();
        let (sin, cos) = sun_theta.sin_cos();
        let sun_radiance = sun_radiance(sky.turbidity, sun_theta);
        // Half of a disc on the horizon gives little; its cosine is that of its centre.
        let projected_sr = PI * sun_radius().sin().powi(2) * cos.max(0.0);
        let mut daylight = Daylight {
            sky,
            sun: [sun_phi.cos() * sin, cos, sun_phi.sin() * sin],
            sun_radiance,
            sky_irradiance: [0.0; 3],
            sun_irradiance: sun_radiance.map(|l| l * projected_sr),
            ground: [0.0; 3],
            sun_theta,
            sun_phi,
            zenith: zenith(sky.turbidity, sun_theta),
            perez: perez(sky.turbidity),
        };
        daylight.sky_irradiance = daylight.irradiance();
        daylight.ground = std::array::from_fn(|c| {
            sky.ground_albedo[c] * (daylight.sky_irradiance[c] + daylight.sun_irradiance[c]) / PI
        });
        daylight
    }

    /// Radiance from direction `d` (of any length) in kcd/m², the sun's disc left out.
    pub fn radiance(&self, d: [f64; 3]) -> [f64; 3] {
        let [x, y, z] = normalized(d);
        if y < 0.0 {
            return self.ground;
        }
        let cos_sun = x * self.sun[0] + y * self.sun[1] + z * self.sun[2];
        let gamma = cos_sun.clamp(-1.0, 1.0).acos();
        let [luminance, x, y] = std::array::from_fn(|i| {
            let ratio = formula(&self.perez[i], y, gamma) / formula(&self.perez[i], 1.0, self.sun_theta);
            self.zenith[i] * ratio
        });
        // The fit leaves the gamut of sRGB at some horizons; nothing there is darker than black.
        observer::rgb_of_xyz([luminance * x / y, luminance, luminance * (1.0 - x - y) / y]).map(|v| v.max(0.0))
    }

    /// The picture, `height` rows: each texel is a mean over its solid angle, of sky and ground by 2 × 2 Gauss points, of
    /// the disc by the exact area that it covers.
    ///
    /// # Panics
    /// When `height` is 0.
    pub fn equirect(&self, height: u32) -> Equirect {
        assert!(height > 0, "a picture has at least one row");
        let width = 2 * height;
        let points = gauss_legendre(2);
        let rows = (0..height).into_par_iter().flat_map_iter(|row| {
            let of = |i: u32, node: &Node, n: u32| (f64::from(i) + 0.5 + 0.5 * node.x) / f64::from(n);
            let points = points.clone();
            (0..width).map(move |column| {
                let mut sum = [0.0; 3];
                for v in points.iter().map(|node| of(row, node, height)) {
                    for u in points.iter().map(|node| of(column, node, width)) {
                        let radiance = self.radiance(Equirect::direction(u, v));
                        (0..3).for_each(|c| sum[c] += 0.25 * radiance[c]);
                    }
                }
                sum.map(|v| v as f32)
            })
        });
        let mut picture = Equirect { width, height, texels: rows.collect() };
        if self.sky.sun_disc {
            self.draw_disc(&mut picture);
        }
        picture
    }

    /// Adds the part of the disc that is above the horizon.
    fn draw_disc(&self, picture: &mut Equirect) {
        let (width, height) = (picture.width, picture.height);
        let (d_theta, d_phi) = (PI / f64::from(height), TAU / f64::from(width));
        let radius = sun_radius();
        let [first, last] = [self.sun_theta - radius, self.sun_theta + radius].map(|t| t / d_theta);
        for row in first.max(0.0) as u32..(last as u32 + 1).min(height) {
            let theta = [f64::from(row) * d_theta, (f64::from(row + 1) * d_theta).min(FRAC_PI_2)];
            let solid_angle = picture.solid_angle_sr(row);
            for column in 0..width {
                let phi = f64::from(column) * d_phi - PI;
                let share = disc_area(radius, self.sun_theta, theta, [phi - self.sun_phi, phi + d_phi - self.sun_phi])
                    / solid_angle;
                if share > 0.0 {
                    let texel = &mut picture.texels[(row * width + column) as usize];
                    (0..3).for_each(|c| texel[c] += (share * self.sun_radiance[c]) as f32);
                }
            }
        }
    }

    /// ∫ L cos θ dω of the sky over the upper hemisphere.
    fn irradiance(&self) -> [f64; 3] {
        const AZIMUTHS: usize = 96;
        let mut sum = [0.0; 3];
        for node in gauss_legendre(48) {
            // In cos² θ, whose measure is that of the projected solid angle.
            let cos = (0.5 + 0.5 * node.x).sqrt();
            let sin = (1.0 - cos * cos).sqrt();
            for i in 0..AZIMUTHS {
                let (along, across) = (TAU * (i as f64 + 0.5) / AZIMUTHS as f64).sin_cos();
                let radiance = self.radiance([along * sin, cos, across * sin]);
                (0..3).for_each(|c| sum[c] += 0.5 * node.weight * PI / AZIMUTHS as f64 * radiance[c]);
            }
        }
        sum
    }
}

/// The disc's angular radius in radians.
fn sun_radius() -> f64 {
    (0.5 * SUN_DIAMETER_DEG).to_radians()
}

/// (1 + A exp(B/cos θ)) (1 + C exp(D γ) + E cos² γ). Perez et al. 1993; Preetham et al. 1999, Eq. 3.
fn formula([a, b, c, d, e]: &[f64; 5], cos_theta: f64, gamma: f64) -> f64 {
    let cos_gamma = gamma.cos();
    (1.0 + a * (b / cos_theta.max(1e-9)).exp()) * (1.0 + c * (d * gamma).exp() + e * cos_gamma * cos_gamma)
}

/// A to E of Y, x and y, linear in the turbidity. Preetham et al. 1999, appendix A.2.
fn perez(turbidity: f64) -> [[f64; 5]; 3] {
    const SLOPE: [[f64; 5]; 3] = [
        [0.1787, -0.3554, -0.0227, 0.1206, -0.0670],
        [-0.0193, -0.0665, -0.0004, -0.0641, -0.0033],
        [-0.0167, -0.0950, -0.0079, -0.0441, -0.0109],
    ];
    const OFFSET: [[f64; 5]; 3] = [
        [-1.4630, 0.4275, 5.3251, -2.5771, 0.3703],
        [-0.2592, 0.0008, 0.2125, -0.8989, 0.0452],
        [-0.2608, 0.0092, 0.2102, -1.6537, 0.0529],
    ];
    std::array::from_fn(|i| std::array::from_fn(|k| SLOPE[i][k] * turbidity + OFFSET[i][k]))
}

/// Y in kcd/m², x and y at the zenith. Preetham et al. 1999, appendix A.2.
fn zenith(turbidity: f64, sun_theta: f64) -> [f64; 3] {
    // Rows by T², T, 1; columns by θ³, θ², θ, 1.
    const X: [[f64; 4]; 3] = [
        [0.00166, -0.00375, 0.00209, 0.0],
        [-0.02903, 0.06377, -0.03202, 0.00394],
        [0.11693, -0.21196, 0.06052, 0.25886],
    ];
    const Y: [[f64; 4]; 3] = [
        [0.00275, -0.00610, 0.00317, 0.0],
        [-0.04214, 0.08970, -0.04153, 0.00516],
        [0.15346, -0.26756, 0.06670, 0.26688],
    ];
    let chi = (4.0 / 9.0 - turbidity / 120.0) * (PI - 2.0 * sun_theta);
    let luminance = (4.0453 * turbidity - 4.9710) * chi.tan() - 0.2155 * turbidity + 2.4192;
    let polynomial = |rows: &[[f64; 4]; 3]| {
        let row = |[a, b, c, d]: [f64; 4]| ((a * sun_theta + b) * sun_theta + c) * sun_theta + d;
        (row(rows[0]) * turbidity + row(rows[1])) * turbidity + row(rows[2])
    };
    [luminance, polynomial(&X), polynomial(&Y)]
}

/// Radiance of the disc in kcd/m². Preetham et al. 1999, appendix A.1.
fn sun_radiance(turbidity: f64, sun_theta: f64) -> [f64; 3] {
    // Kasten 1965.
    let mass = 1.0 / (sun_theta.cos() + 0.15 * (93.885 - sun_theta.to_degrees()).powf(-1.253));
    let beta = 0.04608 * turbidity - 0.04586;
    observer::rgb_of_emission(|wavelength_nm| {
        let micrometres = 1e-3 * wavelength_nm;
        let optical_depth = 0.008735 * micrometres.powf(-4.08) + beta * micrometres.powf(-1.3);
        1e-3 * black_body(wavelength_nm, SUN_TEMPERATURE_K) * (-optical_depth * mass).exp()
    })
    .map(|v| v.max(0.0))
}

/// Planck's law: spectral radiance in W/(m² sr nm).
fn black_body(wavelength_nm: f64, temperature_k: f64) -> f64 {
    // 2hc² in W nm⁴/m² and hc/k in nm K, CODATA 2018.
    const C1: f64 = 1.191_042_972e20;
    const C2: f64 = 1.438_776_877e7;
    C1 / (wavelength_nm.powi(5) * (C2 / (wavelength_nm * temperature_k)).exp_m1())
}

/// Solid angle that a disc of angular radius `radius` about the direction at polar angle `centre` and azimuth 0 has in
/// common with the cell `theta` × `phi`, in steradians; exact to about 1e-9 of the disc.
///
/// At polar angle θ the disc reaches from −Δ to Δ, cos Δ = (cos r − cos θ cos θ_s)/(sin θ sin θ_s): the integral of
/// sin θ times what lies in `phi` is smooth between the ends of the disc and the places where Δ passes an end of `phi`.
fn disc_area(radius: f64, centre: f64, theta: [f64; 2], phi: [f64; 2]) -> f64 {
    let (low, high) = (theta[0].max(centre - radius), theta[1].min(centre + radius));
    if low >= high {
        return 0.0;
    }
    let (sin_centre, cos_centre) = centre.sin_cos();
    let mut breaks = vec![low, high, radius - centre];
    for phi in phi {
        // cos r = cos θ cos θ_s + sin θ sin θ_s cos φ.
        let (a, b) = (cos_centre, sin_centre * phi.cos());
        let ratio = radius.cos() / a.hypot(b);
        if ratio < 1.0 {
            let (middle, half) = (b.atan2(a), ratio.acos());
            breaks.extend([middle - half, middle + half]);
        }
    }
    breaks.retain(|t| (low..=high).contains(t));
    breaks.sort_by(f64::total_cmp);
    let common = |theta: f64| {
        let cos = (radius.cos() - theta.cos() * cos_centre) / (theta.sin() * sin_centre).max(1e-300);
        let delta = cos.clamp(-1.0, 1.0).acos();
        // `phi` counts from the sun and may lie one turn away from it.
        [-TAU, 0.0, TAU].map(|turn| (phi[1] + turn).min(delta) - (phi[0] + turn).max(-delta)).map(|c| c.max(0.0))
    };
    let panel = |ends: &[f64]| {
        // The smooth step takes the root at the disc's ends away.
        let sum = gauss_legendre(16).into_iter().map(|node| {
            let g = 0.5 + 0.5 * node.x;
            let theta = ends[0] + (ends[1] - ends[0]) * g * g * (3.0 - 2.0 * g);
            0.5 * node.weight * 6.0 * g * (1.0 - g) * theta.sin() * common(theta).iter().sum::<f64>()
        });
        (ends[1] - ends[0]) * sum.sum::<f64>()
    };
    breaks.windows(2).map(panel).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn luminance([r, g, b]: [f64; 3]) -> f64 {
        0.2126 * r + 0.7152 * g + 0.0722 * b
    }

    /// Mean over the sphere of the disc alone.
    fn disc_mean(sky: Sky, height: u32) -> [f64; 3] {
        let mut picture = Equirect::from_fn(height, |_, _| [0.0; 3]);
        sky.resolve().expect("valid").draw_disc(&mut picture);
        picture.mean()
    }

    #[test]
    fn zenith_luminance_is_the_papers() {
        // Preetham et al. 1999, appendix A.2, at T = 2 with the sun 45° up, by hand.
        let sky = Sky { turbidity: 2.0, sun_elevation_deg: 45.0, ..Sky::default() }.resolve().expect("valid");
        let chi = (4.0 / 9.0 - 2.0 / 120.0) * FRAC_PI_2;
        let expected = 3.1196 * chi.tan() + 1.9882;
        let found = luminance(sky.radiance([0.0, 1.0, 0.0]));
        assert!((found / expected - 1.0).abs() < 1e-3, "{found} {expected}");
    }

    #[test]
    fn disc_keeps_its_energy_whatever_the_texels() {
        let whole = TAU * (1.0 - sun_radius().cos()) / (4.0 * PI);
        for (elevation, azimuth) in [(3.0, 0.0), (40.0, 180.0), (40.0, 125.0), (89.9, 10.0), (90.0, 0.0)] {
            let sky = Sky { sun_elevation_deg: elevation, sun_azimuth_deg: azimuth, ..Sky::default() };
            let sun = sky.resolve().expect("valid").sun_radiance;
            for height in [3, 64, 512, 1000] {
                let mean = disc_mean(sky, height);
                for c in 0..3 {
                    let expected = whole * sun[c];
                    // A low sun has no blue at all.
                    let near = (mean[c] - expected).abs() <= 1e-5 * expected;
                    assert!(near, "{elevation} {azimuth} {height}: {mean:?}");
                }
            }
        }
    }

    #[test]
    fn disc_on_the_horizon_is_cut_in_half() {
        let sky = Sky { sun_elevation_deg: 0.0, ..Sky::default() };
        let sun = sky.resolve().expect("valid").sun_radiance;
        let half = PI * (1.0 - sun_radius().cos()) / (4.0 * PI);
        for height in [64, 65, 512] {
            let mean = disc_mean(sky, height);
            assert!((mean[0] / (half * sun[0]) - 1.0).abs() < 1e-4, "{height}: {mean:?}");
        }
    }

    #[test]
    fn disc_lies_where_the_sun_is() {
        let daylight = Sky { sun_disc: true, ..Sky::default() }.resolve().expect("valid");
        let picture = daylight.equirect(256);
        let brightest =
            (0..picture.texels.len()).max_by(|a, b| picture.texels[*a][1].total_cmp(&picture.texels[*b][1]));
        let at = brightest.expect("texels");
        let (x, y) = (at % 512, at / 512);
        let d = Equirect::direction((x as f64 + 0.5) / 512.0, (y as f64 + 0.5) / 256.0);
        let cos: f64 = d.iter().zip(daylight.sun).map(|(a, b)| a * b).sum();
        assert!(cos > 0.9999, "{d:?} {:?}", daylight.sun);
    }

    #[test]
    fn light_on_the_ground_is_that_of_a_clear_day() {
        // Above the air the sun gives 120 to 135 klx; a clear day's direct light is 70 to 110 klx, its sky gives 10 to 25, and
        // the fit is known to be bright.
        let noon = Sky { sun_elevation_deg: 60.0, ..Sky::default() }.resolve().expect("valid");
        let direct = luminance(noon.sun_irradiance) / noon.sun[1];
        assert!((70.0..110.0).contains(&direct), "{direct}");
        let diffuse = luminance(noon.sky_irradiance);
        assert!((8.0..35.0).contains(&diffuse), "{diffuse}");
        // Low suns are dim and red.
        let evening = Sky { sun_elevation_deg: 3.0, ..Sky::default() }.resolve().expect("valid");
        assert!(evening.sun_radiance[0] > 3.0 * evening.sun_radiance[2]);
        assert!(luminance(evening.sun_radiance) < 0.3 * luminance(noon.sun_radiance));
    }

    #[test]
    fn black_body_radiates_the_solar_constant() {
        // 1361 W/m² above the air: Stefan–Boltzmann over the disc of mean size.
        let total: f64 = (100..40_000).map(|nm| black_body(f64::from(nm), SUN_TEMPERATURE_K)).sum();
        let irradiance = total * PI * sun_radius().sin().powi(2);
        assert!((irradiance / 1361.0 - 1.0).abs() < 0.02, "{irradiance}");
    }

    #[test]
    fn ground_reflects_what_falls_on_it() {
        let daylight = Sky { ground_albedo: [0.5, 0.2, 0.0], ..Sky::default() }.resolve().expect("valid");
        let below = daylight.radiance([0.3, -0.2, 0.1]);
        // From a picture: the upper half's cosine-weighted sum.
        let picture = daylight.equirect(256);
        for c in 0..2 {
            let irradiance: f64 = (0..128)
                .map(|y| {
                    let cos = (PI * (f64::from(y) + 0.5) / 256.0).cos();
                    let row: f64 = picture.row(y).iter().map(|t| f64::from(t[c])).sum();
                    cos * picture.solid_angle_sr(y) * row
                })
                .sum();
            let expected = daylight.sky.ground_albedo[c] * (irradiance + daylight.sun_irradiance[c]) / PI;
            assert!((below[c] / expected - 1.0).abs() < 1e-3, "{c}: {below:?} {expected}");
        }
        assert_eq!(below[2], 0.0);
    }

    #[test]
    fn every_day_is_finite_and_not_negative() {
        for turbidity in [2.0, 3.0, 6.0, 10.0] {
            for elevation in [0.0, 0.3, 5.0, 45.0, 90.0] {
                let sky = Sky { turbidity, sun_elevation_deg: elevation, sun_disc: true, ..Sky::default() };
                let picture = sky.resolve().expect("valid").equirect(31);
                let bad = picture.texels.iter().find(|t| t.iter().any(|v| !(v.is_finite() && *v >= 0.0)));
                assert_eq!(bad, None, "{turbidity} {elevation}");
            }
        }
    }

    #[test]
    fn numbers_out_of_range_are_refused() {
        let ok = Sky::default();
        for (sky, word) in [
            (Sky { turbidity: 1.0, ..ok }, "turbidity"),
            (Sky { turbidity: f64::NAN, ..ok }, "turbidity"),
            (Sky { sun_elevation_deg: -1.0, ..ok }, "elevation"),
            (Sky { sun_azimuth_deg: f64::INFINITY, ..ok }, "azimuth"),
            (Sky { ground_albedo: [0.0, 1.1, 0.0], ..ok }, "albedo"),
        ] {
            let error = sky.resolve().expect_err("refused").to_string();
            assert!(error.contains(word), "{error}");
        }
    }
}
