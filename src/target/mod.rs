// SPDX-License-Identifier: MIT OR Apache-2.0
//! What engines want of a file: one file per engine, and their registry.
//!
//! A [`Target`] holds presets for tables and for environments: sizes, axes, channels, encodings, containers, the law of the
//! mips, which way the file's axes point, and what goes beside it. Every choice can be overridden by an explicit flag; the
//! file then says which ones were. The conventions come from the engines' own sources, which each target names.

mod babylon;
mod bevy;
mod blender;
mod filament;
mod gltf;
mod godot;
mod materialx;
mod openpbr;
mod playcanvas;
mod three;
mod unity_hdrp;
mod unreal;

use crate::axis::{Points, Warp};
use crate::bake::layers::JOINT;
use crate::bake::{RoughnessLaw, SliceAxis};
use crate::error::{Error, Result, nearest};
use crate::format::{self, Encoding, Format};
use crate::texture::{Meta, Shape};

/// The name that stands for all tables of an engine.
pub const SET: &str = "set";
/// The flags and the keys of recipes that go with it: all others would make its tables differ from what the engine takes.
pub const OF_SET: [&str; 5] = ["table", "for", "output", "compression", "bc-quality"];

/// An engine.
pub struct Target {
    /// The name used on the command line and in files.
    pub name: &'static str,
    /// Two lines for lists: what it takes, and what its user should know.
    pub about: [&'static str; 2],
    /// Where its conventions are written down: files of its source.
    pub source: &'static str,
    /// Its tables, the usual one first.
    pub tables: &'static [TablePreset],
    /// Its environments.
    pub environment: Option<EnvironmentPreset>,
}

/// How an engine wants a table.
#[derive(Clone, Copy, Debug)]
pub struct TablePreset {
    /// Name of the table.
    pub table: &'static str,
    /// Name of the distribution.
    pub ndf: &'static str,
    /// Name of the geometry term.
    pub visibility: &'static str,
    /// Width and height in texels, of a slice where there are some.
    pub size: (u32, u32),
    /// What runs along x and y.
    pub axes: &'static [Warp],
    /// What runs over the slices, and how many there are.
    pub slices: Option<(SliceAxis, u32)>,
    /// The table in the layer behind it, of the same size and axes: the engine reads both from one array texture.
    pub behind: Option<&'static TablePreset>,
    /// Where in its texel a value is taken.
    pub points: Points,
    /// Row 0 holds the largest position.
    pub flip_v: bool,
    /// Every row holds what belongs this many rows further along.
    pub row_shift: u32,
    /// What the channels hold.
    pub channels: &'static [&'static str],
    /// Source code has a plane for each channel, one after the other.
    pub planes: bool,
    /// Name of the file where the user gives none, without its extension.
    pub stem: &'static str,
    /// The container's extension.
    pub extension: &'static str,
    /// How texels are stored.
    pub encoding: &'static str,
    /// The code that loads it; `{file}` stands for the file's name.
    pub snippet: &'static str,
}

impl TablePreset {
    /// Itself and the tables in the layers behind it.
    pub fn layers(&self) -> impl Iterator<Item = &TablePreset> {
        std::iter::successors(Some(self), |preset| preset.behind)
    }

    /// The name of its table, or of its tables, layer by layer.
    pub fn table_name(&self) -> String {
        self.layers().map(|preset| preset.table).collect::<Vec<_>>().join(&JOINT.to_string())
    }

    /// Names of its axes, that over the slices last.
    pub fn axis_names(&self) -> Vec<String> {
        let slices = self.slices.map(|(map, _)| map.to_string());
        self.axes.iter().map(|axis| axis.name().to_string()).chain(slices).collect()
    }

    /// Scale and bias over n·v and roughness as half floats: what most engines take.
    const SPLIT_SUM: TablePreset = TablePreset {
        table: "split-sum",
        ndf: "ggx",
        visibility: "smith",
        size: (128, 128),
        axes: &[Warp::NDotV, Warp::Roughness],
        slices: None,
        behind: None,
        points: Points::Centers,
        flip_v: false,
        row_shift: 0,
        channels: &["scale", "bias"],
        planes: false,
        stem: "dfg",
        extension: "ktx2",
        encoding: "rg16f",
        snippet: "",
    };

    /// The matrix of linearly transformed cosines as it was published.
    const LTC: TablePreset = TablePreset {
        table: "ltc",
        size: (64, 64),
        axes: &[Warp::Roughness, Warp::SqrtOneMinusNDotV],
        points: Points::Edges,
        channels: &["m00", "m20", "m02", "m22"],
        stem: "ltc_1",
        encoding: "rgba16f",
        ..TablePreset::SPLIT_SUM
    };

    /// What belongs to it.
    const LTC_MAGNITUDE: TablePreset = TablePreset {
        table: "ltc-magnitude",
        channels: &["magnitude", "fresnel", "unused", "sphere"],
        stem: "ltc_2",
        ..TablePreset::LTC
    };
}

/// How an engine wants an environment.
#[derive(Clone, Copy, Debug)]
pub struct EnvironmentPreset {
    /// Name of the projection.
    pub shape: &'static str,
    /// Texels along an edge of mip 0; the height of an equirect.
    pub size: u32,
    /// How many mips.
    pub mips: Mips,
    /// Which roughness a mip holds.
    pub law: RoughnessLaw,
    /// Which way the file's axes point, as [`crate::env::FileAxes::parse`] reads it.
    pub file_axes: &'static str,
    /// The container's extension.
    pub extension: &'static str,
    /// How texels are stored.
    pub encoding: &'static str,
    /// What the file's name ends with before its extension, where the user gives no name.
    pub suffix: &'static str,
    /// What is written beside it.
    pub beside: &'static [Beside],
    /// The code that loads it; `{file}` stands for the file's name, `{diffuse}` and `{skybox}` for those beside it.
    pub snippet: &'static str,
}

impl EnvironmentPreset {
    /// A cube of half floats with all mips.
    const CUBE: EnvironmentPreset = EnvironmentPreset {
        shape: "cube",
        size: 256,
        mips: Mips::DownTo(1),
        law: RoughnessLaw::Linear,
        file_axes: "x,y,z",
        extension: "ktx2",
        encoding: "rgba16f",
        suffix: "_specular",
        beside: &[],
        snippet: "",
    };

    /// A picture for engines that filter it themselves.
    const EQUIRECT: EnvironmentPreset = EnvironmentPreset {
        shape: "equirect",
        size: 1024,
        mips: Mips::AtMost(1),
        extension: "exr",
        suffix: "_equirect",
        ..EnvironmentPreset::CUBE
    };
}

/// How many mips a preset asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mips {
    /// Down to this many texels along an edge.
    DownTo(u32),
    /// This many, or down to one texel.
    AtMost(u32),
}

impl Mips {
    /// The number for an edge of `size` texels at mip 0.
    pub fn of(self, size: u32) -> u32 {
        match self {
            Mips::DownTo(least) => size.max(least).ilog2() - least.ilog2() + 1,
            Mips::AtMost(mips) => mips.min(size.max(1).ilog2() + 1),
        }
    }
}

/// Another file that an engine loads together with the specular one.
#[derive(Clone, Copy, Debug)]
pub struct Beside {
    /// What it holds.
    pub content: Content,
    /// Texels along an edge; `None` is that of the specular map.
    pub size: Option<u32>,
    /// What its name ends with before the extension.
    pub suffix: &'static str,
}

/// What a file beside the specular one holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Content {
    /// Irradiance over π.
    Diffuse,
    /// The environment itself.
    Skybox,
}

/// Every target, in alphabetical order.
pub static TARGETS: &[&Target] = &[
    &babylon::TARGET,
    &bevy::TARGET,
    &blender::TARGET,
    &filament::TARGET,
    &gltf::TARGET,
    &godot::TARGET,
    &materialx::TARGET,
    &openpbr::TARGET,
    &playcanvas::TARGET,
    &three::TARGET,
    &unity_hdrp::TARGET,
    &unreal::TARGET,
];

/// The target with this name.
pub fn parse(name: &str) -> Result<&'static Target> {
    TARGETS
        .iter()
        .copied()
        .find(|t| t.name == name)
        .ok_or_else(|| Error::usage(format!("unknown target '{name}'"), nearest(name, TARGETS.iter().map(|t| t.name))))
}

impl Target {
    /// Its preset for a table, by the table's name or by the engine's own, its file's.
    pub fn table(&self, table: &str) -> Result<&'static TablePreset> {
        let named = self.tables.iter().find(|p| p.stem == table);
        let of_table = || self.tables.iter().find(|p| p.table == table || p.table_name() == table);
        named.or_else(of_table).ok_or_else(|| {
            if let Some(whole) = self.tables.iter().find(|p| p.layers().any(|layer| layer.table == table)) {
                let what = format!("{} takes {table} as a layer of {}", self.name, whole.stem);
                return Error::usage(what, format!("bake {} --for {}", whole.stem, self.name));
            }
            let mut known: Vec<&str> = self.tables.iter().flat_map(|p| [p.table, p.stem]).collect();
            known.sort_unstable();
            known.dedup();
            let help = match known[..] {
                [] => "it computes its own; `brdf-baker env` has a preset for it".to_string(),
                _ => format!("it takes {}", known.join(", ")),
            };
            Error::usage(format!("{} takes no {table} table", self.name), help)
        })
    }

    /// Its preset for an environment.
    pub fn environment(&'static self) -> Result<&'static EnvironmentPreset> {
        let help = "`brdf-baker bake` has presets of its tables";
        self.environment.as_ref().ok_or_else(|| Error::usage(format!("{} takes no environment", self.name), help))
    }
}

/// Which target a file is for, and what its user chose instead of the preset.
#[derive(Debug, Default)]
pub struct Choice {
    target: Option<&'static str>,
    overrides: Vec<&'static str>,
}

impl Choice {
    /// Of a target, or of none.
    pub fn of(target: Option<&Target>) -> Choice {
        Choice { target: target.map(|t| t.name), overrides: vec![] }
    }

    /// The target's name.
    pub fn target(&self) -> Option<&'static str> {
        self.target
    }

    /// What the user gave, else the preset's, else the default. A value that differs from the preset's is an override.
    pub fn pick<T: PartialEq>(&mut self, what: &'static str, given: Option<T>, preset: Option<T>, default: T) -> T {
        match (given, preset) {
            (Some(given), Some(preset)) => {
                if given != preset {
                    self.overrides.push(what);
                }
                given
            }
            (Some(value), None) | (None, Some(value)) => value,
            (None, None) => default,
        }
    }

    /// The encoding: the user's, else the preset's, else the container's. A container that cannot hold the preset's
    /// takes its own, which is an override that the file states.
    pub fn encoding(
        &mut self,
        format: &dyn Format,
        shape: Shape,
        channels: usize,
        given: Option<Encoding>,
        preset: Option<Encoding>,
    ) -> Result<Encoding> {
        let held = |encoding: &Encoding| format.encodings(shape).contains(encoding) && encoding.components >= channels;
        let wanted = given.or(preset.filter(held));
        let encoding = format::choose(format, shape, channels, wanted)?;
        if preset.is_some_and(|preset| preset != encoding) {
            self.overrides.push("encoding");
        }
        Ok(encoding)
    }

    /// Notes a container that is not the preset's.
    pub fn container(&mut self, format: &dyn Format, preset: &str) {
        if !format.extension().eq_ignore_ascii_case(preset) {
            self.overrides.push("container");
        }
    }

    /// What was overridden.
    pub fn overrides(&self) -> &[&'static str] {
        &self.overrides
    }

    /// Writes it down in a file.
    pub fn describe(&self, meta: &mut Meta) {
        if let Some(target) = self.target {
            meta.set("target", target);
            if !self.overrides.is_empty() {
                meta.set("target.overrides", self.overrides.join(","));
            }
        }
    }
}

/// The code that loads a file, for the target that it names; `None` where it names none, or the target has no code for it.
pub fn snippet(meta: &Meta, file: &str) -> Option<String> {
    let target = parse(meta.get("target")?).ok()?;
    match meta.get("table") {
        Some(table) => Some(target.table(table).ok()?.snippet.replace("{file}", file)).filter(|s| !s.is_empty()),
        None => {
            let preset = target.environment.as_ref()?;
            let mut snippet = preset.snippet.replace("{file}", file);
            for beside in preset.beside {
                let name = match beside.content {
                    Content::Diffuse => "{diffuse}",
                    Content::Skybox => "{skybox}",
                };
                snippet = snippet.replace(name, &beside_name(file, preset, beside));
            }
            Some(snippet).filter(|s| !s.is_empty())
        }
    }
}

/// The name of a file beside the specular one: `yard_specular.ktx2` has `yard_diffuse.ktx2`, `yard.ktx2` too.
pub fn beside_name(file: &str, preset: &EnvironmentPreset, beside: &Beside) -> String {
    let (stem, extension) = file.rsplit_once('.').unwrap_or((file, preset.extension));
    let stem = stem.strip_suffix(preset.suffix).unwrap_or(stem);
    format!("{stem}{}.{extension}", beside.suffix)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bake::atlas::{self, Atlas};
    use crate::bake::specular::SpecularRequest;
    use crate::bake::{LayersJob, TableRequest, VolumeJob};
    use crate::env::FileAxes;

    #[test]
    fn every_preset_of_a_table_can_be_baked_and_stored() {
        for target in TARGETS {
            for p in target.tables {
                let request = |p: &TablePreset| TableRequest {
                    size: p.size,
                    ndf: p.ndf.into(),
                    visibility: p.visibility.into(),
                    axes: Some(p.axes.iter().map(|w| w.name().into()).collect()),
                    points: p.points,
                    flip_v: p.flip_v,
                    row_shift: p.row_shift,
                    channels: Some(p.channels.iter().map(|c| c.to_string()).collect()),
                    ..TableRequest::new(p.table)
                };
                let job = request(p).resolve().unwrap_or_else(|e| panic!("{} {}: {e}", target.name, p.table));
                let shape = match (p.slices, p.behind) {
                    (Some((map, depth)), _) => VolumeJob::new(&request(p), map, depth).expect(p.stem).shape(),
                    (None, Some(_)) => {
                        let requests: Vec<TableRequest> = p.layers().map(request).collect();
                        LayersJob::new(&requests).expect(p.stem).shape()
                    }
                    (None, None) => Shape::Table,
                };
                let format = format::named(p.extension).expect(p.extension);
                let encoding = Encoding::parse(p.encoding).expect(p.encoding);
                format::choose(format, shape, job.channels.len(), Some(encoding))
                    .unwrap_or_else(|e| panic!("{} {}: {e}", target.name, p.table));
            }
        }
    }

    #[test]
    fn every_preset_of_an_environment_can_be_baked_and_stored() {
        for target in TARGETS {
            let Some(p) = &target.environment else { continue };
            let request = SpecularRequest {
                shape: p.shape.into(),
                size: Some(p.size),
                mips: Some(p.mips.of(p.size)),
                roughness_law: p.law.name().into(),
                ..SpecularRequest::default()
            };
            let (job, levels) = match p.shape {
                atlas::NAME => (Atlas::new(p.size, "standard").expect("its size").specular, 1),
                _ => request
                    .resolve()
                    .map(|job| (job.clone(), job.mips))
                    .unwrap_or_else(|e| panic!("{}: {e}", target.name)),
            };
            FileAxes::parse(p.file_axes).expect(p.file_axes);
            let format = format::named(p.extension).expect(p.extension);
            let encoding = Encoding::parse(p.encoding).expect(p.encoding);
            format::choose(format, job.shape(), 3, Some(encoding)).unwrap_or_else(|e| panic!("{}: {e}", target.name));
            assert!(format.holds_mips() || levels == 1, "{}", target.name);
        }
    }

    #[test]
    fn names_are_sorted_and_unique() {
        assert!(TARGETS.windows(2).all(|pair| pair[0].name < pair[1].name));
        assert!(parse("bevi").err().expect("it is no target").help().starts_with("did you mean 'bevy'?"));
    }

    #[test]
    fn mips_end_where_the_preset_says() {
        assert_eq!(Mips::DownTo(1).of(256), 9);
        assert_eq!(Mips::DownTo(8).of(256), 6);
        assert_eq!(Mips::DownTo(8).of(4), 1);
        assert_eq!(Mips::AtMost(7).of(128), 7);
        assert_eq!(Mips::AtMost(7).of(16), 5);
    }

    #[test]
    fn an_override_is_what_differs() {
        let mut choice = Choice::of(Some(&bevy::TARGET));
        assert_eq!(choice.pick("size", Some(32), Some(64), 256), 32);
        assert_eq!(choice.pick("mips", Some(9), Some(9), 1), 9);
        assert_eq!(choice.pick("encoding", None, Some("rg16f"), "r32f"), "rg16f");
        let mut meta = Meta::default();
        choice.describe(&mut meta);
        assert_eq!(meta.iter().collect::<Vec<_>>(), [("target", "bevy"), ("target.overrides", "size")]);
    }
}
