// SPDX-License-Identifier: MIT OR Apache-2.0
//! Bevy: cubes as KTX2, the split-sum table through the feature `dfg_lut`.

use super::{Beside, Content, EnvironmentPreset, Mips, TablePreset, Target};

const AREA_LIGHTS: &str =
    "// Cargo.toml: bevy 0.19 or later with the features area_light_luts and ktx2; after the plugins:
let image: Handle<Image> = app.world().resource::<AssetServer>().load(\"{file}\");
app.sub_app_mut(RenderApp).insert_resource(bevy::pbr::AreaLightLuts { image });";

pub(super) static TARGET: Target = Target {
    name: "bevy",
    about: [
        "KTX2: 128x128 split-sum table, both tables of area lights as the layers of ltc; 512 specular cube, roughness m/M down to 4 texels, with a 32 diffuse cube beside it",
        "The shader looks cubes up with z reversed, so the file's +Z shows the environment's -Z",
    ],
    source: "bevy_pbr: environment_map.wesl, pbr_lighting.wesl, light_probe; area lights: pbr_lighting.wgsl, AreaLightLuts",
    tables: &[
        TablePreset {
            // With 64, blending between texels makes a rough metal err by a third more.
            size: (128, 128),
            snippet: "// Cargo.toml: bevy with the features dfg_lut, ktx2 and zstd_rust; after the plugins:
let table: Handle<Image> = app.world().resource::<AssetServer>().load(\"{file}\");
app.sub_app_mut(RenderApp).insert_resource(bevy::pbr::DfgLut { texture: table });",
            ..TablePreset::SPLIT_SUM
        },
        TablePreset {
            behind: Some(&TablePreset::LTC_MAGNITUDE),
            stem: "ltc",
            snippet: AREA_LIGHTS,
            ..TablePreset::LTC
        },
    ],
    environment: Some(EnvironmentPreset {
        file_axes: "x,y,-z",
        // With 256, seven mips are left: too few for the error between two of them to stay under that of Bevy's own filter.
        size: 512,
        // Between the last mips Bevy interpolates evenly in roughness: smaller ones would err more than their number gains.
        mips: Mips::DownTo(4),
        beside: &[Beside { content: Content::Diffuse, size: Some(32), suffix: "_diffuse" }],
        snippet: "commands.entity(camera).insert(EnvironmentMapLight {
    specular_map: assets.load(\"{file}\"),
    diffuse_map: assets.load(\"{diffuse}\"),
    intensity: 1.0, // candela per square metre for one unit of the file
    ..default()
});",
        ..EnvironmentPreset::CUBE
    }),
};
