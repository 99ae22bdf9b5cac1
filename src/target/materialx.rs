// SPDX-License-Identifier: MIT OR Apache-2.0
//! MaterialX: pictures with mips, a table over n·v and alpha.

use super::{Beside, Content, EnvironmentPreset, Mips, TablePreset, Target};
use crate::axis::Warp;
use crate::bake::RoughnessLaw;

pub(super) static TARGET: Target = Target {
    name: "materialx",
    about: [
        "EXR picture of 1024x512 with prefiltered mips down to 8x4, alpha t^2 and then linear, and a picture of irradiance beside it",
        "64x64 table of scale and bias over n.v and alpha, the width itself, as 32-bit EXR",
    ],
    source: "MaterialX: mx_generate_albedo_table.glsl, mx_environment_prefilter.glsl, mx_generate_prefilter_env.glsl",
    tables: &[TablePreset {
        size: (64, 64),
        axes: &[Warp::NDotV, Warp::Alpha],
        stem: "albedo_table",
        extension: "exr",
        encoding: "rgba32f",
        snippet: "// u_albedoTable: {file}
vec3 ggxDirAlbedo = F0 * texture(u_albedoTable, vec2(NdotV, alpha)).x + F90 * texture(u_albedoTable, vec2(NdotV, alpha)).y;",
        ..TablePreset::SPLIT_SUM
    }],
    environment: Some(EnvironmentPreset {
        shape: "equirect",
        size: 512,
        // Roughness 1 is looked up at 7/8 of the mips: down to one texel, a metal would be off by 10 % there, like this by 1 %.
        mips: Mips::DownTo(4),
        law: RoughnessLaw::Materialx,
        extension: "exr",
        beside: &[Beside { content: Content::Diffuse, size: Some(64), suffix: "_irradiance" }],
        snippet: "// u_envRadiance: {file} (u_envRadianceMips = its parts), u_envIrradiance: {diffuse}",
        ..EnvironmentPreset::CUBE
    }),
};
