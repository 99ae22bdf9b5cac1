// SPDX-License-Identifier: MIT OR Apache-2.0
//! Spherical harmonics as JSON: coefficients with everything that a reader must know to use them.

use serde_json::{Value, json};

use crate::env::sh::{BASIS, Window, cosine_factor};

/// The file's content. `radiance` holds L_lm as [`crate::env::sh::project`] gives them, for l ≤ `order`; `input` is the
/// name of the picture. Both lists of coefficients that are written have the window applied.
pub fn sh_json(radiance: &[[f64; 3]], order: u32, window: Window, input: &str) -> Value {
    let band = |i: usize| BASIS[i].0;
    let scaled = |of: &dyn Fn(u32) -> f64| -> Vec<[f64; 3]> {
        let factor = |i: usize| of(band(i)) * window.factor(band(i), order);
        radiance.iter().enumerate().map(|(i, c)| c.map(|v| v * factor(i))).collect()
    };
    let bands: Vec<u32> = (0..=order).collect();
    let basis: Vec<Value> =
        BASIS[..radiance.len()].iter().map(|(l, m, formula)| json!({ "l": l, "m": m, "Y": formula })).collect();
    json!({
        "what": "real spherical harmonics of an environment",
        "writer": super::WRITER,
        "input": input,
        "order": order,
        "index": "l*l + l + m",
        "basis": basis,
        "axes": "x, y, z is the unit direction that light comes from; +Y is up; an equirectangular input has +X in the \
                 middle and +Z at u = 3/4",
        "channels": ["r", "g", "b"],
        "window": {
            "name": window.name(),
            "factors": bands.iter().map(|l| window.factor(*l, order)).collect::<Vec<_>>(),
        },
        "radiance": {
            "meaning": "L_lm = integral of L(w) Y_lm(w) dw over the sphere; L(w) is about the sum of L_lm Y_lm(w)",
            "units": "linear RGB radiance of the input times steradian",
            "coefficients": scaled(&|_| 1.0),
        },
        "irradiance": {
            "meaning": "E_lm = A_l L_lm; the irradiance E(n) is about the sum of E_lm Y_lm(n), n the surface normal; \
                        a white Lambert surface reflects E/pi",
            "units": "linear RGB radiance of the input times steradian squared",
            "A": bands.iter().map(|l| cosine_factor(*l)).collect::<Vec<_>>(),
            "coefficients": scaled(&cosine_factor),
        },
        "integration": "exact over every texel's solid angle, f64",
    })
}
