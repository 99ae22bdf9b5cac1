// SPDX-License-Identifier: MIT OR Apache-2.0
//! A thin film on a metal or a dielectric, whose two reflections interfere: iridescence.
//!
//! For one wavelength and polarisation, with the real reflection coefficient a at the film, z = rho exp(i delta) at the base
//! below it, and the phase phi = 4π n d cos θ/λ that light gains in the film, all internal reflections add up to
//!
//! R = |(a + z e^{i phi})/(1 + a z e^{i phi})|² = 1 − (1 − a²)(1 − rho²)/(1 + a² rho² + 2 a rho cos(phi + delta))
//!
//! (Airy's sum; Belcour, Barla 2017, Eq. 3), a form in which nothing cancels. Linear sRGB is the mean over the spectrum under
//! D65 with the CIE observer, each row of which ([`SAMPLES`]) stands for a triangle of 5 nm to either side, so that thick
//! films fade instead of aliasing. Indices do not vary with the wavelength; those of a metal are its pair of each channel. A
//! reflectance that all wavelengths share is that number in each channel; a saturated one may carry a channel out of [0, 1],
//! because it lies outside the primaries of sRGB.
//!
//! A film of 0 nm is the base alone. The reflectance over v·h is expanded once a film into a Chebyshev series, whose tail is
//! below 1e-9 for films up to [`FILM_NM`].

use std::cell::RefCell;
use std::f64::consts::PI;
use std::sync::{Arc, Mutex, PoisonError};

use super::{Optics, Term, Weights};
use crate::material::observer::SAMPLES;
use crate::quadrature::gauss_legendre::gauss_legendre;

/// Thicknesses that are baked, in nm.
pub const FILM_NM: [f64; 2] = [0.0, 3000.0];
/// Refractive indices of films that are baked.
pub const FILM_IOR: [f64; 2] = [1.05, 3.0];

/// Registry entry.
pub static FILM: Term = Term {
    name: "film",
    about: "thin film (--film INDEX,NM) on an exact dielectric or conductor, interference in linear sRGB under D65",
    source: "Belcour, Barla 2017, A Practical Extension to Microfacet Theory for the Modeling of Varying Iridescence, Eq. 3",
    file: None,
    weights,
    kink: None,
    azimuth: None,
    breaks: Some(breaks),
};

/// Path difference in nm that a panel of the ring rule may run through: between one and two fringes.
const PANEL_NM: f64 = 800.0;

/// Evenly along the path difference, which runs from that of a right angle to that of normal incidence.
fn breaks(optics: &Optics) -> Vec<f64> {
    let [ior, nm] = optics.given;
    let least = ((ior - 1.0) * (ior + 1.0)).sqrt() / ior;
    let panels = (2.0 * ior * nm * (1.0 - least) / PANEL_NM).ceil();
    let at = |i: u32| {
        let cos_film = least + (1.0 - least) * f64::from(i) / panels;
        (1.0 - ior * ior * (1.0 - cos_film) * (1.0 + cos_film)).max(0.0).sqrt()
    };
    (1..panels as u32).map(at).collect()
}

/// Terms of a series.
const TERMS: usize = 96;

/// Reflectances of red, green and blue as Chebyshev series in 2 v·h − 1.
struct Series {
    of: Optics,
    coefficients: Vec<[f64; 3]>,
}

/// The series of the last film: all threads of a slice ask for the same one.
static LAST: Mutex<Option<Arc<Series>>> = Mutex::new(None);

thread_local! {
    /// What a thread last had from there.
    static OF_THREAD: RefCell<Option<Arc<Series>>> = const { RefCell::new(None) };
}

/// 1 and the reflectance of red, green and blue. Host only.
pub fn weights(v_dot_h: f64, optics: &Optics) -> Weights {
    OF_THREAD.with_borrow_mut(|last| {
        let series = match last {
            Some(series) if series.of == *optics => series,
            _ => last.insert(shared(optics)),
        };
        let [r, g, b] = series.at(v_dot_h);
        [1.0, r, g, b]
    })
}

/// The series that all threads share, made by the first that asks.
fn shared(optics: &Optics) -> Arc<Series> {
    let mut last = LAST.lock().unwrap_or_else(PoisonError::into_inner);
    match &*last {
        Some(series) if series.of == *optics => series.clone(),
        _ => last.insert(Arc::new(Series::new(optics))).clone(),
    }
}

impl Series {
    fn new(optics: &Optics) -> Series {
        let mut spectra = Spectra::new(optics);
        let angle = |j: usize| PI * (j as f64 + 0.5) / TERMS as f64;
        let values: Vec<[f64; 3]> = (0..TERMS).map(|j| spectra.reflectance(0.5 + 0.5 * angle(j).cos())).collect();
        let coefficient = |k: usize| -> [f64; 3] {
            let scale = if k == 0 { 1.0 } else { 2.0 } / TERMS as f64;
            std::array::from_fn(|c| {
                values.iter().enumerate().map(|(j, v)| v[c] * (k as f64 * angle(j)).cos() * scale).sum()
            })
        };
        Series { of: *optics, coefficients: (0..TERMS).map(coefficient).collect() }
    }

    /// Clenshaw's recurrence.
    fn at(&self, v_dot_h: f64) -> [f64; 3] {
        let x = 2.0 * v_dot_h - 1.0;
        let (mut b1, mut b2) = ([0.0; 3], [0.0; 3]);
        for c in self.coefficients[1..].iter().rev() {
            let next = std::array::from_fn(|i| c[i] + 2.0 * x * b1[i] - b2[i]);
            (b1, b2) = (next, b1);
        }
        std::array::from_fn(|i| self.coefficients[0][i] + x * b1[i] - b2[i])
    }
}

/// Wavelengths, as 1/λ in 1/nm, and what each counts in red, green and blue.
type Spectrum = Vec<(f64, [f64; 3])>;

/// The spectrum of a film as finely as its fringes ask for.
struct Spectra {
    optics: Optics,
    /// The phase that light gains in the film between two samples, where it changes most.
    phase: f64,
    /// By the binary logarithm of the nodes between two samples.
    by_fineness: [Option<Spectrum>; FINEST + 1],
}

/// Binary logarithm of the most nodes between two samples.
const FINEST: usize = 8;

impl Spectra {
    fn new(optics: &Optics) -> Spectra {
        let [ior, nm] = optics.given;
        let (first_nm, step_nm) = (SAMPLES[0].wavelength_nm, SAMPLES[1].wavelength_nm - SAMPLES[0].wavelength_nm);
        let phase = 4.0 * PI * ior * nm * step_nm / (first_nm * first_nm);
        Spectra { optics: *optics, phase, by_fineness: Default::default() }
    }

    /// For fringes whose reflection coefficients have the product `g`: towards grazing on a metal they are narrow.
    fn of_fringes(&mut self, g: f64) -> &Spectrum {
        let nodes = 6.0 + self.phase * (2.0 + 2.0 / (1.0 - g).max(1e-3));
        let fineness = (nodes.log2().ceil() as usize).min(FINEST);
        self.by_fineness[fineness].get_or_insert_with(|| spectrum(1 << fineness))
    }

    /// Reflectance of red, green and blue at cosine `c`.
    fn reflectance(&mut self, c: f64) -> [f64; 3] {
        let Optics { eta, k, given: [ior, nm] } = self.optics;
        let cos_film = (1.0 - (1.0 - c) * (1.0 + c) / (ior * ior)).sqrt();
        let phase_nm = 4.0 * PI * ior * nm * cos_film;
        let mut rgb = [0.0; 3];
        // A base without colour is the same for all channels.
        let plain = eta == [eta[0]; 3] && k == [k[0]; 3];
        let groups: &[&[usize]] = if plain { &[&[0, 1, 2]] } else { &[&[0], &[1], &[2]] };
        for group in groups {
            let first = group[0];
            for (film, base) in interfaces(c, cos_film, ior, eta[first], k[first]) {
                let (rho, shift) = (base[0].hypot(base[1]), base[1].atan2(base[0]));
                let (mean, swing) = (1.0 + film * film * rho * rho, 2.0 * film * rho);
                let lost = (1.0 - film) * (1.0 + film) * (1.0 - rho) * (1.0 + rho);
                // Both polarisations alike.
                for (inverse_nm, weight) in self.of_fringes(film.abs() * rho) {
                    let r = 0.5 - 0.5 * lost / (mean + swing * (phase_nm * inverse_nm + shift).cos());
                    group.iter().for_each(|i| rgb[*i] += weight[*i] * r);
                }
            }
        }
        rgb
    }
}

/// The spectrum with so many nodes between two samples.
fn spectrum(nodes: usize) -> Spectrum {
    let samples = &*SAMPLES;
    let (first_nm, step_nm) = (samples[0].wavelength_nm, samples[1].wavelength_nm - samples[0].wavelength_nm);
    let rule = gauss_legendre(nodes);
    let mut spectrum = vec![];
    // One triangle reaches beyond either end.
    for i in 0..=samples.len() {
        let weights = |i: Option<usize>| i.and_then(|i| samples.get(i)).map_or([0.0; 3], |s| s.weight_rgb);
        let (before, after) = (weights(i.checked_sub(1)), weights(Some(i)));
        for node in &rule {
            let t = 0.5 + 0.5 * node.x;
            let wavelength_nm = first_nm + step_nm * (i as f64 - 1.0 + t);
            let weight = std::array::from_fn(|c| 0.5 * node.weight * ((1.0 - t) * before[c] + t * after[c]));
            spectrum.push((1.0 / wavelength_nm, weight));
        }
    }
    spectrum
}

/// Reflection coefficients of the film and, complex, of the base under it, for both polarisations (Fresnel's equations).
fn interfaces(c: f64, cos_film: f64, ior: f64, eta: f64, k: f64) -> [(f64, [f64; 2]); 2] {
    let film_s = (c - ior * cos_film) / (c + ior * cos_film);
    let film_p = (ior * c - cos_film) / (ior * c + cos_film);
    // The wave's normal component in the base, in units of that in vacuum: the root of (eta + i k)² − sin².
    let (re2, im2) = (eta * eta - k * k - (1.0 - c) * (1.0 + c), 2.0 * eta * k);
    let length = re2.hypot(im2);
    let normal = if re2 >= 0.0 {
        let re = (0.5 * (length + re2)).sqrt();
        [re, if re > 0.0 { 0.5 * im2 / re } else { 0.0 }]
    } else {
        let im = (0.5 * (length - re2)).sqrt();
        [0.5 * im2 / im, im]
    };
    let inside = ior * cos_film;
    let base_s = quotient([inside - normal[0], -normal[1]], [inside + normal[0], normal[1]]);
    // The square of the base's index times the film's cosine, over that of the film.
    let square = [(eta * eta - k * k) * cos_film / ior, im2 * cos_film / ior];
    let base_p =
        quotient([square[0] - normal[0], square[1] - normal[1]], [square[0] + normal[0], square[1] + normal[1]]);
    [(film_s, base_s), (film_p, base_p)]
}

fn quotient([a, b]: [f64; 2], [c, d]: [f64; 2]) -> [f64; 2] {
    let length2 = c * c + d * d;
    [(a * c + b * d) / length2, (b * c - a * d) / length2]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quadrature::adaptive::{Estimate, integrate};
    use crate::term::fresnel::{Fresnel, conductor, dielectric};

    fn film(ior: f64, nm: f64, base: Fresnel) -> Fresnel {
        Fresnel::film(base, ior, nm).expect("in range")
    }

    fn glass() -> Fresnel {
        Fresnel::dielectric(1.5).expect("in range")
    }

    fn gold() -> Fresnel {
        Fresnel::conductor([0.14, 0.37, 1.44], [4.1, 2.4, 1.9]).expect("in range")
    }

    #[test]
    fn film_of_no_thickness_is_the_base_alone() {
        for c in [0.0, 0.01, 0.3, 0.7, 1.0] {
            for r in &film(1.33, 0.0, glass()).weights(c)[1..] {
                assert!((r - dielectric::dielectric(c, 1.5)).abs() < 1e-9, "{c}: {r}");
            }
            let (base, of_film) = (gold().weights(c), film(1.8, 0.0, gold()).weights(c));
            (0..4).for_each(|i| assert!((base[i] - of_film[i]).abs() < 1e-9, "{c}: {base:?} {of_film:?}"));
        }
        let metal = conductor::conductor(0.4, 0.14, 4.1);
        assert!((film(2.0, 0.0, gold()).weights(0.4)[1] - metal).abs() < 1e-9);
    }

    #[test]
    fn quarter_wave_film_of_the_mean_index_hides_its_base() {
        // One wavelength: a = −rho and a phase of π.
        let ior = 1.5f64.sqrt();
        let [(a, z), _] = interfaces(1.0, 1.0, ior, 1.5, 0.0);
        assert!((a - z[0]).abs() < 1e-15 && z[1].abs() < 1e-15, "{a} {z:?}");
    }

    /// Belcour and Barla's own way: the Fourier series of the reflectance over the phase, each term with the transform of the
    /// channel's sensitivity at that path difference, here by adaptive integration over the wavelength.
    fn by_fourier(c: f64, optics: &Optics, channel: usize) -> f64 {
        let [ior, nm] = optics.given;
        let cos_film = (1.0 - (1.0 - c * c) / (ior * ior)).sqrt();
        let path_nm = 2.0 * ior * nm * cos_film;
        let samples = &*SAMPLES;
        let breaks: Vec<f64> = (0..samples.len() + 2).map(|i| 355.0 + 5.0 * i as f64).collect();
        let sensitivity = |path_nm: f64| {
            let weight = |lambda: f64| {
                let at = (lambda - 360.0) / 5.0;
                let of = |i: f64| samples.get(i as usize).filter(|_| i >= 0.0).map_or(0.0, |s| s.weight_rgb[channel]);
                let t = at - at.floor();
                ((1.0 - t) * of(at.floor()) + t * of(at.floor() + 1.0)) / 5.0
            };
            integrate(&breaks, 1e-9, 5000, |lambda| {
                let (sin, cos) = (2.0 * PI * path_nm / lambda).sin_cos();
                Estimate { value: [weight(lambda) * cos, weight(lambda) * sin], error: 0.0 }
            })
            .value
        };
        let mut sum = 0.0;
        for (a, z) in interfaces(c, cos_film, ior, optics.eta[channel], optics.k[channel]) {
            let rho = z[0].hypot(z[1]);
            let (g, delta) = (a * rho, z[1].atan2(z[0]));
            let mut series = 1.0;
            for m in 1..200 {
                let size = 2.0 * (-g).powi(m);
                if size.abs() < 1e-9 {
                    break;
                }
                let [re, im] = sensitivity(f64::from(m) * path_nm);
                let (sin, cos) = (f64::from(m) * delta).sin_cos();
                series += size * (cos * re - sin * im);
            }
            sum += 0.5 * (1.0 - (1.0 - a * a) * (1.0 - rho * rho) * series / (1.0 - g * g));
        }
        sum
    }

    #[test]
    fn reflectance_is_that_of_belcour_and_barla() {
        let mut worst = 0.0f64;
        for (ior, nm, base) in [
            (1.33, 120.0, glass()),
            (1.33, 550.0, gold()),
            (1.33, 400.0, Fresnel::interface(1.0)),
            (2.4, 300.0, glass()),
            (2.0, 1500.0, gold()),
        ] {
            let fresnel = film(ior, nm, base);
            for c in [0.1, 0.45, 1.0] {
                // Towards grazing a thick film on a metal has more terms than are worth a test.
                if c < 0.4 && nm > 1000.0 {
                    continue;
                }
                for channel in [0, 2] {
                    let found = fresnel.weights(c)[channel + 1];
                    let expected = by_fourier(c, &fresnel.optics, channel);
                    worst = worst.max((found - expected).abs());
                    assert!((found - expected).abs() <= 1e-7, "{ior} {nm} {c} {channel}: {found}, {expected}");
                }
            }
        }
        println!("thin film against its Fourier series: worst {worst:.1e}");
    }
}
