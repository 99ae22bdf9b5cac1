// SPDX-License-Identifier: MIT OR Apache-2.0
//! Unity's high definition pipeline: its FGD table, and a cube with its roughness law.

use super::{EnvironmentPreset, Mips, TablePreset, Target};
use crate::axis::{Points, Warp};
use crate::bake::RoughnessLaw;

/// What lit surfaces read.
const FGD: TablePreset = TablePreset {
    size: (64, 64),
    axes: &[Warp::SqrtNDotV, Warp::Roughness],
    points: Points::Edges,
    channels: &["bias", "albedo", "disney-diffuse"],
    stem: "fgd_ggx_disney",
    extension: "dds",
    encoding: "a2b10g10r10",
    snippet: "float2 uv = Remap01ToHalfTexelCoord(float2(sqrt(NdotV), perceptualRoughness), 64); // {file}
float3 fgd = SAMPLE_TEXTURE2D_LOD(_PreIntegratedFGD, s_linear_clamp_sampler, uv, 0).xyz;
float3 specularFGD = lerp(fgd.xxx, fgd.yyy, fresnel0);
float diffuseFGD = fgd.z + 0.5;",
    ..TablePreset::SPLIT_SUM
};

/// What fabric reads: sheen over 2π, which the shader multiplies back, and a diffuse term.
const FGD_FABRIC: TablePreset = TablePreset {
    ndf: "charlie",
    visibility: "charlie",
    axes: &[Warp::NDotV, Warp::Roughness],
    points: Points::Centers,
    channels: &["charlie-bias", "charlie-albedo", "fabric-lambert"],
    stem: "fgd_charlie_fabric",
    snippet: "float3 fgd = SAMPLE_TEXTURE2D_LOD(_PreIntegratedFGD_CharlieAndFabric, s_linear_clamp_sampler,
    float2(NdotV, perceptualRoughness), 0).xyz; // {file}
float3 specularFGD = lerp(fgd.xxx, fgd.yyy, fresnel0) * 2.0 * PI;
float diffuseFGD = fgd.z;",
    ..FGD
};

pub(super) static TARGET: Target = Target {
    name: "unity-hdrp",
    about: [
        "DDS cube of 256 half floats whose mips 0 to 6 hold the roughness that the pipeline's shaders look up",
        "64x64 tables: bias, scale + bias and Disney's diffuse term; the same of sheen with fabric's; ltc_ggx. Not Marschner's of hair",
    ],
    source: "Unity Graphics: ImageBasedLighting.hlsl, PreIntegratedFGD.hlsl, preIntegratedFGD_GGXDisneyDiffuse.shader, preIntegratedFGD_CharlieFabricLambert.shader, BSDF.hlsl, LTCAreaLight.hlsl",
    tables: &[
        FGD,
        FGD_FABRIC,
        TablePreset {
            channels: &["m00/m22", "m20/m22", "m11/m22", "m02/m22"],
            stem: "ltc_ggx",
            extension: "dds",
            snippet: "// {file}: half floats of slice LTCLightingModel.GGX of _LtcData, in the place of s_LtcMatrixData_BRDF_GGX
// SampleLtcMatrix(perceptualRoughness, clampedNdotV, LTCLIGHTINGMODEL_GGX) reads it; magnitude and Fresnel are its FGD table's",
            ..TablePreset::LTC
        },
    ],
    environment: Some(EnvironmentPreset {
        mips: Mips::AtMost(7),
        law: RoughnessLaw::Unity,
        extension: "dds",
        snippet: "float lod = perceptualRoughness * (1.7 - 0.7 * perceptualRoughness) * 6; // PerceptualRoughnessToMipmapLevel
float3 radiance = SAMPLE_TEXTURECUBE_LOD(cube, s_trilinear_clamp_sampler, R, lod).rgb; // {file}",
        ..EnvironmentPreset::CUBE
    }),
};
