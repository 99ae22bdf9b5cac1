// SPDX-License-Identifier: MIT OR Apache-2.0
//! `brdf-baker list` and `brdf-baker devices`: everything is printed from the registries.

use brdf_baker::axis::Coordinate;
use brdf_baker::bake::companion::COMPANIONS;
use brdf_baker::bake::{RoughnessLaw, TABLES};
use brdf_baker::format::{ENCODINGS, Encoding, Format, formats};
use brdf_baker::ndf::NDFS;
use brdf_baker::target::{TARGETS, Target};
use brdf_baker::term::fresnel::TERMS;
use brdf_baker::term::visibility::VISIBILITIES;
use brdf_baker::texture::Shape;
use brdf_baker::{Result, gpu};
use clap::ValueEnum;
use serde_json::json;

use super::console::Console;

#[derive(Clone, Copy, PartialEq, clap::ValueEnum)]
pub enum What {
    Tables,
    Ndfs,
    Visibilities,
    Fresnels,
    Kernels,
    Laws,
    Encodings,
    Formats,
    Targets,
}

/// One entry of a registry.
/// Every shape, and what files call it. Of several tables any number will do.
const SHAPES: [(Shape, &str); 5] = [
    (Shape::Table, "tables"),
    (Shape::Volume { depth: 2 }, "volumes"),
    (Shape::Array { layers: 2 }, "arrays"),
    (Shape::Map, "maps"),
    (Shape::Cube, "cubes"),
];

struct Entry {
    name: &'static str,
    about: String,
    source: &'static str,
}

fn entries(what: What) -> (&'static str, Vec<Entry>) {
    let own = String::from;
    match what {
        What::Tables => {
            let entry = |t: &&dyn brdf_baker::bake::Table| {
                let facts = t.facts();
                let mut channels: Vec<_> = (facts.channels)(&facts.fresnel).iter().map(|c| c.name).collect();
                channels.extend(facts.complement.map(|c| c.name));
                channels.extend(t.derived().iter().map(|d| d.channel.name));
                if facts.axes == [Coordinate::NDotV, Coordinate::Roughness] {
                    channels.extend(COMPANIONS.iter().map(|c| c.channel.name));
                }
                let about = format!("{} (channels {})", facts.about, channels.join(", "));
                Entry { name: facts.name, about, source: facts.source }
            };
            ("tables", TABLES.iter().map(entry).collect())
        }
        What::Ndfs => {
            let entry = |n: &&brdf_baker::ndf::Family| {
                let mut about = own(n.about);
                if !n.also.is_empty() {
                    about.push_str(&format!("; also called {}", n.also.join(", ")));
                }
                for p in n.parameters {
                    let [low, high] = p.range;
                    let need = if p.required { "needed" } else { "optional" };
                    about.push_str(&format!("; {}= {} ({low} to {high}, {need})", p.name, p.about));
                }
                Entry { name: n.name, about, source: n.source }
            };
            ("ndfs", NDFS.iter().map(entry).collect())
        }
        What::Visibilities => {
            let entry = |v: &&brdf_baker::term::visibility::Visibility| Entry {
                name: v.name,
                about: own(v.about),
                source: v.source,
            };
            ("visibilities", VISIBILITIES.iter().map(entry).collect())
        }
        What::Fresnels => {
            let entry =
                |f: &&brdf_baker::term::fresnel::Term| Entry { name: f.name, about: own(f.about), source: f.source };
            ("fresnels", TERMS.iter().map(entry).collect())
        }
        What::Kernels => (
            "kernels",
            super::env::kernels().map(|(name, about, source)| Entry { name, about: own(about), source }).collect(),
        ),
        What::Laws => {
            let entry = |law: &RoughnessLaw| Entry { name: law.name(), about: own(law.about()), source: "" };
            ("laws", RoughnessLaw::ALL.iter().map(entry).collect())
        }
        What::Targets => {
            let entry = |t: &&'static Target| Entry { name: t.name, about: t.about.join("\n"), source: t.source };
            ("targets", TARGETS.iter().map(entry).collect())
        }
        What::Encodings => {
            let about = |encoding| {
                let holders: Vec<String> = formats()
                    .iter()
                    .filter(|f| SHAPES.iter().any(|(shape, _)| f.encodings(*shape).contains(encoding)))
                    .map(|f| format!(".{}", f.extension()))
                    .collect();
                holders.join(" ")
            };
            ("encodings", ENCODINGS.iter().map(|e| Entry { name: e.name, about: about(e), source: "" }).collect())
        }
        What::Formats => {
            let entry = |f: &&'static dyn Format| {
                let held = SHAPES.iter().filter(|(shape, _)| !f.encodings(*shape).is_empty());
                let held: Vec<&str> = held.map(|(_, word)| *word).collect();
                let mips = if f.holds_mips() { "mips" } else { "one level" };
                let meta = if f.holds_meta() { "" } else { ", no metadata" };
                let is_held = |e: &&Encoding| SHAPES.iter().any(|(shape, _)| f.encodings(*shape).contains(e));
                let names: Vec<&str> = ENCODINGS.iter().filter(is_held).map(|e| e.name).collect();
                let about = format!("{}: {} ({mips}{meta}) as {}", f.name(), held.join(", "), names.join(" "));
                Entry { name: f.extension(), about, source: "" }
            };
            ("formats", formats().iter().map(entry).collect())
        }
    }
}

pub fn run(what: Option<What>, console: &mut Console) -> Result<()> {
    for what in What::value_variants().iter().copied().filter(|w| what.is_none_or(|chosen| chosen == *w)) {
        let (registry, entries) = entries(what);
        let mut text = registry.to_string();
        let mut list = vec![];
        for e in entries {
            for (i, line) in e.about.lines().enumerate() {
                text.push_str(&format!("\n  {:20} {line}", if i == 0 { e.name } else { "" }));
            }
            if !e.source.is_empty() {
                text.push_str(&format!("\n  {:20}   {}", "", e.source));
            }
            list.push(json!({ "name": e.name, "about": e.about, "source": e.source }));
        }
        console.result(&text, &json!({ "registry": registry, "entries": list }))?;
    }
    Ok(())
}

pub fn devices(console: &mut Console) -> Result<()> {
    for d in gpu::devices()? {
        let text = format!("{}  {}  {}  Vulkan {}  {}  {}", d.index, d.name, d.kind.name(), d.api, d.driver, d.uuid);
        let value = json!({
            "index": d.index,
            "name": d.name,
            "kind": d.kind.name(),
            "api": d.api,
            "driver": d.driver,
            "uuid": d.uuid,
            "max_buffer_bytes": d.max_buffer_bytes,
        });
        console.result(text.trim_end(), &value)?;
    }
    Ok(())
}
