// SPDX-License-Identifier: MIT OR Apache-2.0
//! From a spectrum of reflectance, or of light, to linear sRGB.
//!
//! The light is CIE standard illuminant D65, the white of sRGB, so that a perfect reflector is exactly (1, 1, 1): with any
//! other illuminant, the equal-energy one too, a grey metal would take on a tint that the white of the picture does not have.

use std::sync::LazyLock;

use glam::{DMat3, DVec3};

/// First and last wavelength of the sum, in nm. Beyond it the observer sees less than 1e-5 of the light.
pub const RANGE_NM: [f64; 2] = [360.0, 780.0];

/// A wavelength and how much its reflectance counts in each channel.
#[derive(Clone, Copy, Debug)]
pub struct Sample {
    /// Wavelength in air.
    pub wavelength_nm: f64,
    /// Weight in red, green and blue of linear sRGB; each channel's weights sum to 1, some are negative.
    pub weight_rgb: [f64; 3],
}

/// Every 5 nm of [`RANGE_NM`].
///
/// Weight ∝ P⁻¹ (x̄, ȳ, z̄) S with P the columns of the primaries of sRGB (IEC 61966-2-1) and S the illuminant. Scaling each
/// row to the sum 1 is what chooses the primaries' luminances in the usual derivation of the matrix of sRGB; the white is that
/// of the tables, (0.31271, 0.32901), where the standard rounds to (0.3127, 0.3290).
pub static SAMPLES: LazyLock<Vec<Sample>> = LazyLock::new(|| {
    let to_rgb = primaries().inverse();
    let raw = |[_, x, y, z, d65]: &[f64; 5]| to_rgb * (DVec3::new(*x, *y, *z) * *d65);
    let white: DVec3 = OBSERVER_AND_D65.iter().map(raw).sum();
    let sample = |row: &[f64; 5]| Sample { wavelength_nm: row[0], weight_rgb: (raw(row) / white).to_array() };
    OBSERVER_AND_D65.iter().map(sample).collect()
});

/// The primaries of sRGB (IEC 61966-2-1), each of luminance 1, as columns of XYZ.
fn primaries() -> DMat3 {
    let xyz = |x: f64, y: f64| DVec3::new(x / y, 1.0, (1.0 - x - y) / y);
    DMat3::from_cols(xyz(0.64, 0.33), xyz(0.30, 0.60), xyz(0.15, 0.06))
}

/// From XYZ to linear sRGB: the white of [`SAMPLES`] at Y = 1 becomes (1, 1, 1).
static TO_RGB: LazyLock<DMat3> = LazyLock::new(|| {
    let of_white = |[_, x, y, z, d65]: &[f64; 5]| DVec3::new(*x, *y, *z) * *d65;
    let white: DVec3 = OBSERVER_AND_D65.iter().map(of_white).sum();
    let to_rgb = primaries().inverse();
    DMat3::from_diagonal((to_rgb * (white / white.y)).recip()) * to_rgb
});

/// Linear sRGB of a colour in CIE 1931 XYZ, in the unit of its Y: 0.2126 r + 0.7152 g + 0.0722 b is Y.
pub fn rgb_of_xyz(xyz: [f64; 3]) -> [f64; 3] {
    (*TO_RGB * DVec3::from_array(xyz)).to_array()
}

/// Linear sRGB of a spectral radiance in W/(m² sr nm), in cd/m²: K_m ∫ L ȳ dλ with K_m = 683 lm/W is the luminance.
pub fn rgb_of_emission(radiance: impl Fn(f64) -> f64) -> [f64; 3] {
    let step_nm = OBSERVER_AND_D65[1][0] - OBSERVER_AND_D65[0][0];
    let part = |[wavelength_nm, x, y, z, _]: &[f64; 5]| DVec3::new(*x, *y, *z) * radiance(*wavelength_nm);
    rgb_of_xyz((683.0 * step_nm * OBSERVER_AND_D65.iter().map(part).sum::<DVec3>()).to_array())
}

/// Linear sRGB of a reflectance spectrum under D65; (1, 1, 1) for a perfect reflector. Saturated spectra leave [0, 1].
pub fn rgb(reflectance: impl Fn(f64) -> f64) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for s in SAMPLES.iter() {
        let value = reflectance(s.wavelength_nm);
        for (sum, weight) in sum.iter_mut().zip(s.weight_rgb) {
            *sum += weight * value;
        }
    }
    sum
}

/// Wavelength in nm; x̄, ȳ, z̄ of the CIE 1931 2° observer and relative power of D65 (CIE 15:2004).
const OBSERVER_AND_D65: [[f64; 5]; 85] = [
    [360.0, 0.0001299, 3.917e-06, 0.0006061, 46.6383],
    [365.0, 0.0002321, 6.965e-06, 0.001086, 49.3637],
    [370.0, 0.0004149, 1.239e-05, 0.001946, 52.0891],
    [375.0, 0.0007416, 2.202e-05, 0.003486, 51.0323],
    [380.0, 0.001368, 3.9e-05, 0.00645, 49.9755],
    [385.0, 0.002236, 6.4e-05, 0.01055, 52.3118],
    [390.0, 0.004243, 0.00012, 0.02005, 54.6482],
    [395.0, 0.00765, 0.000217, 0.03621, 68.7015],
    [400.0, 0.01431, 0.000396, 0.06785, 82.7549],
    [405.0, 0.02319, 0.00064, 0.1102, 87.1204],
    [410.0, 0.04351, 0.00121, 0.2074, 91.486],
    [415.0, 0.07763, 0.00218, 0.3713, 92.4589],
    [420.0, 0.13438, 0.004, 0.6456, 93.4318],
    [425.0, 0.21477, 0.0073, 1.0391, 90.057],
    [430.0, 0.2839, 0.0116, 1.3856, 86.6823],
    [435.0, 0.3285, 0.01684, 1.623, 95.7736],
    [440.0, 0.34828, 0.023, 1.7471, 104.865],
    [445.0, 0.34806, 0.0298, 1.7826, 110.936],
    [450.0, 0.3362, 0.038, 1.7721, 117.008],
    [455.0, 0.3187, 0.048, 1.7441, 117.41],
    [460.0, 0.2908, 0.06, 1.6692, 117.812],
    [465.0, 0.2511, 0.0739, 1.5281, 116.336],
    [470.0, 0.19536, 0.09098, 1.2876, 114.861],
    [475.0, 0.1421, 0.1126, 1.0419, 115.392],
    [480.0, 0.09564, 0.13902, 0.81295, 115.923],
    [485.0, 0.05795, 0.1693, 0.6162, 112.367],
    [490.0, 0.03201, 0.20802, 0.46518, 108.811],
    [495.0, 0.0147, 0.2586, 0.3533, 109.082],
    [500.0, 0.0049, 0.323, 0.272, 109.354],
    [505.0, 0.0024, 0.4073, 0.2123, 108.578],
    [510.0, 0.0093, 0.503, 0.1582, 107.802],
    [515.0, 0.0291, 0.6082, 0.1117, 106.296],
    [520.0, 0.06327, 0.71, 0.07825, 104.79],
    [525.0, 0.1096, 0.7932, 0.05725, 106.239],
    [530.0, 0.1655, 0.862, 0.04216, 107.689],
    [535.0, 0.22575, 0.91485, 0.02984, 106.047],
    [540.0, 0.2904, 0.954, 0.0203, 104.405],
    [545.0, 0.3597, 0.9803, 0.0134, 104.225],
    [550.0, 0.43345, 0.99495, 0.00875, 104.046],
    [555.0, 0.51205, 1.0, 0.00575, 102.023],
    [560.0, 0.5945, 0.995, 0.0039, 100.0],
    [565.0, 0.6784, 0.9786, 0.00275, 98.1671],
    [570.0, 0.7621, 0.952, 0.0021, 96.3342],
    [575.0, 0.8425, 0.9154, 0.0018, 96.0611],
    [580.0, 0.9163, 0.87, 0.00165, 95.788],
    [585.0, 0.9786, 0.8163, 0.0014, 92.2368],
    [590.0, 1.0263, 0.757, 0.0011, 88.6856],
    [595.0, 1.0567, 0.6949, 0.001, 89.3459],
    [600.0, 1.0622, 0.631, 0.0008, 90.0062],
    [605.0, 1.0456, 0.5668, 0.0006, 89.8026],
    [610.0, 1.0026, 0.503, 0.00034, 89.5991],
    [615.0, 0.9384, 0.4412, 0.00024, 88.6489],
    [620.0, 0.85445, 0.381, 0.00019, 87.6987],
    [625.0, 0.7514, 0.321, 0.0001, 85.4936],
    [630.0, 0.6424, 0.265, 5e-05, 83.2886],
    [635.0, 0.5419, 0.217, 3e-05, 83.4939],
    [640.0, 0.4479, 0.175, 2e-05, 83.6992],
    [645.0, 0.3608, 0.1382, 1e-05, 81.863],
    [650.0, 0.2835, 0.107, -1.9058e-21, 80.0268],
    [655.0, 0.2187, 0.0816, 0.0, 80.1207],
    [660.0, 0.1649, 0.061, 0.0, 80.2146],
    [665.0, 0.1212, 0.04458, 0.0, 81.2462],
    [670.0, 0.0874, 0.032, 0.0, 82.2778],
    [675.0, 0.0636, 0.0232, 0.0, 80.281],
    [680.0, 0.04677, 0.017, 0.0, 78.2842],
    [685.0, 0.0329, 0.01192, 0.0, 74.0027],
    [690.0, 0.0227, 0.00821, 0.0, 69.7213],
    [695.0, 0.01584, 0.005723, 0.0, 70.6652],
    [700.0, 0.011359, 0.004102, 0.0, 71.6091],
    [705.0, 0.0081109, 0.002929, 0.0, 72.979],
    [710.0, 0.0057903, 0.002091, 0.0, 74.349],
    [715.0, 0.0041095, 0.001484, 0.0, 67.9765],
    [720.0, 0.0028993, 0.001047, 0.0, 61.604],
    [725.0, 0.0020492, 0.00074, 0.0, 65.7448],
    [730.0, 0.00144, 0.00052, 0.0, 69.8856],
    [735.0, 0.00099995, 0.0003611, 0.0, 72.4863],
    [740.0, 0.00069008, 0.0002492, 0.0, 75.087],
    [745.0, 0.00047602, 0.0001719, 0.0, 69.3398],
    [750.0, 0.0003323, 0.00012, 0.0, 63.5927],
    [755.0, 0.00023483, 8.48e-05, 0.0, 55.0054],
    [760.0, 0.00016615, 6e-05, 0.0, 46.4182],
    [765.0, 0.00011741, 4.24e-05, 0.0, 56.6118],
    [770.0, 8.3075e-05, 3e-05, 0.0, 66.8054],
    [775.0, 5.8707e-05, 2.12e-05, 0.0, 65.0941],
    [780.0, 4.151e-05, 1.499e-05, 0.0, 63.3828],
];

#[cfg(test)]
mod tests {
    use std::f64::consts::{PI, TAU};

    use super::*;
    use crate::quadrature::gauss_legendre::gauss_legendre;

    /// Transforms that Blender Cycles publishes for thin films.
    const CYCLES: &str = include_str!("../../tests/golden/cycles_thin_film.txt");

    #[test]
    fn transforms_of_the_observer_are_those_that_cycles_publishes() {
        let rows: Vec<Vec<f64>> = CYCLES
            .lines()
            .filter(|line| !line.starts_with('#'))
            .map(|line| line.split(' ').map(|word| word.parse().expect("a number")).collect())
            .collect();
        let rule = gauss_legendre(12);
        let mut worst = 0.0f64;
        for row in &rows {
            let path_nm = row[0] * 60_000.0 / (2.0 * PI * 511.0);
            for c in 0..3 {
                // Straight lines between the rows of 5 nm.
                let (mut re, mut im, mut all) = (0.0, 0.0, 0.0);
                for ends in OBSERVER_AND_D65.windows(2) {
                    for node in &rule {
                        let t = 0.5 + 0.5 * node.x;
                        let at = |i: usize| ends[0][i] + t * (ends[1][i] - ends[0][i]);
                        let (sin, cos) = (TAU * path_nm / at(0)).sin_cos();
                        let weight = node.weight * at(c + 1);
                        (re, im, all) = (re + weight * cos, im - weight * sin, all + weight);
                    }
                }
                let published = [row[c + 1], row[c + 4]].map(|v| v / rows[0][c + 1]);
                worst = worst.max((re / all - published[0]).hypot(im / all - published[1]));
            }
        }
        // Theirs are of rows of 1 nm, joined by cubics.
        println!("Cycles' transforms of the observer, {} rows: worst {worst:.1e}", rows.len());
        assert!(rows.len() == 9 && worst <= 4e-3, "{worst:e}");
    }
}
