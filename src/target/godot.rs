// SPDX-License-Identifier: MIT OR Apache-2.0
//! Godot: it filters skies itself, so it takes a picture; its table is computed at start-up.

use super::{EnvironmentPreset, TablePreset, Target};

pub(super) static TARGET: Target = Target {
    name: "godot",
    about: [
        "EXR picture of 2048x1024 for a PanoramaSkyMaterial, which the engine filters",
        "128x128 table for shaders of your own: rgba16f, Schlick's term as in the engine, roughness 1 in row 0",
    ],
    source: "Godot: integrate_dfg.glsl, sky.cpp, PanoramaSkyMaterial",
    tables: &[TablePreset {
        // The geometry term of the engine's own table, k = roughness²/2.
        visibility: "schlick-ggx",
        flip_v: true,
        channels: &["bias", "albedo", "cloth"],
        stem: "dfg",
        extension: "exr",
        encoding: "rgba16f",
        snippet: "uniform sampler2D dfg : repeat_disable, filter_linear; // {file}, imported without mipmaps and VRAM compression
vec3 f = texture(dfg, vec2(n_dot_v, 1.0 - roughness)).rgb;
vec3 specular = mix(f.xxx, f.yyy, f0);",
        ..TablePreset::SPLIT_SUM
    }],
    environment: Some(EnvironmentPreset {
        snippet: "var material := PanoramaSkyMaterial.new()
material.panorama = load(\"res://{file}\")
environment.sky = Sky.new()
environment.sky.sky_material = material
environment.background_mode = Environment.BG_SKY",
        ..EnvironmentPreset::EQUIRECT
    }),
};
