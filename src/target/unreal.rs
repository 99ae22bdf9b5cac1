// SPDX-License-Identifier: MIT OR Apache-2.0
//! Unreal Engine: a cube as DDS, and the layout of its pre-integrated table.

use super::{EnvironmentPreset, TablePreset, Target};
use crate::bake::RoughnessLaw;

pub(super) static TARGET: Target = Target {
    name: "unreal",
    about: [
        "DDS cube of 128 half floats, mips as its reflection captures have them; the engine filters what it imports itself",
        "128x32 table of scale and bias over n.v and roughness, 16-bit integers",
    ],
    source: "public ports of Unreal's ReflectionEnvironmentShared.ush and BRDF.ush; the engine's own source is not public",
    tables: &[TablePreset {
        size: (128, 32),
        stem: "preintegrated_gf",
        extension: "dds",
        encoding: "rg16unorm",
        snippet: "float2 AB = Texture2DSampleLevel(PreIntegratedGF, PreIntegratedGFSampler, float2(NoV, Roughness), 0).rg; // {file}
float3 EnvBRDF = SpecularColor * AB.x + saturate(50.0 * SpecularColor.g) * AB.y;",
        ..TablePreset::SPLIT_SUM
    }],
    environment: Some(EnvironmentPreset {
        size: 128,
        law: RoughnessLaw::Unreal,
        // x forward, y right, z up and left-handed: what is up in the environment, its y, is the file's z.
        file_axes: "x,z,y",
        extension: "dds",
        snippet: "float lod = CubemapMaxMip - (1 - 1.2 * log2(max(Roughness, 0.001))); // CubemapMaxMip: the file's last mip
float3 Radiance = TextureCubeSampleLevel(Cube, CubeSampler, R, lod).rgb; // {file}",
        ..EnvironmentPreset::CUBE
    }),
};
