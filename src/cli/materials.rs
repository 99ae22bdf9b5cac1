// SPDX-License-Identifier: MIT OR Apache-2.0
//! `brdf-baker materials`: named metals and dielectrics, printed from their registries.

use brdf_baker::Result;
use brdf_baker::material::{self, Dielectric, Material, Metal, PUBLISHED, srgb};
use serde_json::{Value, json};

use super::console::Console;

/// Wavelengths that n and k are printed at.
const SHOWN_NM: [f64; 5] = [450.0, 500.0, 550.0, 600.0, 650.0];

pub fn run(name: Option<&str>, console: &mut Console) -> Result<()> {
    let shown: Vec<Material> = match name {
        Some(name) => vec![material::parse(name)?],
        None => material::materials().collect(),
    };
    for m in shown {
        let (text, value) = match m {
            Material::Metal(metal) => of_metal(metal),
            Material::Dielectric(dielectric) => of_dielectric(dielectric),
        };
        console.result(text.trim_end(), &value)?;
    }
    Ok(())
}

/// The heading and the lines below it.
struct Text(String);

impl Text {
    fn new(name: &str, kind: &str, also: &[&str]) -> Text {
        let also = if also.is_empty() { String::new() } else { format!(", also called {}", also.join(", ")) };
        Text(format!("{name}  {kind}{also}\n"))
    }

    fn line(&mut self, key: &str, value: &str) {
        self.0.push_str(&format!("  {key:16} {value}\n"));
    }
}

fn joined<T: std::fmt::Display>(values: &[T]) -> String {
    values.iter().map(T::to_string).collect::<Vec<_>>().join(" ")
}

/// Four decimals, two more than 8 bits hold.
fn decimals(values: &[f64]) -> String {
    values.iter().map(|v| format!("{v:.4}")).collect::<Vec<_>>().join(" ")
}

fn of_metal(metal: &Metal) -> (String, Value) {
    let f0 = metal.f0();
    let bits = f0.map(srgb::encode_8_bit);
    let (published, published_bits) = metal.published;
    let difference: [f64; 3] = std::array::from_fn(|c| f0[c].clamp(0.0, 1.0) - published[c]);
    let channels = metal.channels();
    let mut text = Text::new(metal.name, "metal", metal.also);
    text.line("F0", &format!("{} linear, {} as 8-bit sRGB, from n and k", decimals(&f0), joined(&bits)));
    text.line("F0 published", &format!("{} linear, {}", decimals(&published), joined(&published_bits)));
    let signed = difference.map(|d| format!("{d:+.4}"));
    text.line("difference", &format!("{} (from n and k, clipped to [0, 1], less published)", joined(&signed)));
    for wavelength_nm in SHOWN_NM {
        let [n, k] = metal.at(wavelength_nm);
        text.line(&format!("{wavelength_nm} nm"), &format!("n {n:.3}  k {k:.3}"));
    }
    for (name, c) in ["red", "green", "blue"].iter().zip(&channels) {
        let clipped = if c.clipped { ", F0 clipped" } else { "" };
        let fit = format!("eta {:.4}  k {:.4}  within {:.4} of the spectrum's curve{clipped}", c.eta, c.k, c.worst);
        text.line(name, &fit);
    }
    if !metal.note.is_empty() {
        text.line("note", metal.note);
    }
    text.line("n, k from", metal.source);
    text.line("published in", &format!("{PUBLISHED}, Table 9.2"));
    let n_k = SHOWN_NM.map(|wavelength_nm| {
        let [n, k] = metal.at(wavelength_nm);
        json!({ "wavelength_nm": wavelength_nm, "n": n, "k": k })
    });
    let per_channel = channels
        .map(|c| json!({ "eta": c.eta, "k": c.k, "f0": c.f0, "clipped": c.clipped, "max_difference": c.worst }));
    let value = json!({
        "name": metal.name,
        "kind": "metal",
        "also": metal.also,
        "f0_linear": f0,
        "f0_srgb8": bits,
        "published": {
            "f0_linear": published,
            "f0_srgb8": published_bits,
            "difference": difference,
            "source": format!("{PUBLISHED}, Table 9.2"),
        },
        "n_k": n_k,
        "channels": per_channel,
        "note": metal.note,
        "source": metal.source,
    });
    (text.0, value)
}

fn of_dielectric(dielectric: &Dielectric) -> (String, Value) {
    let f0 = dielectric.f0();
    let bits = srgb::encode_8_bit(f0);
    let ([low, high], [low_bits, high_bits]) = dielectric.published;
    let mut text = Text::new(dielectric.name, "dielectric", dielectric.also);
    text.line("F0", &format!("{f0:.4} linear, {bits} as 8-bit sRGB, from n"));
    let range = if low == high {
        format!("{low:.3} linear, {low_bits}")
    } else {
        format!("{low:.3} to {high:.3} linear, {low_bits} to {high_bits}")
    };
    text.line("F0 published", &format!("{range} ({})", dielectric.class));
    text.line("587.6 nm", &format!("n {}", dielectric.n));
    text.line("n from", dielectric.source);
    text.line("published in", &format!("{PUBLISHED}, Table 9.1"));
    let value = json!({
        "name": dielectric.name,
        "kind": "dielectric",
        "also": dielectric.also,
        "f0_linear": ([f0; 3]),
        "f0_srgb8": ([bits; 3]),
        "published": {
            "class": dielectric.class,
            "f0_linear": [low, high],
            "f0_srgb8": [low_bits, high_bits],
            "source": format!("{PUBLISHED}, Table 9.1"),
        },
        "n": dielectric.n,
        "source": dielectric.source,
    });
    (text.0, value)
}
