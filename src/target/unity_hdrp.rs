//! Unity's high definition pipeline: its FGD table, and a cube with its roughness law.

use super::{EnvironmentPreset, Mips, TablePreset, Target};
use crate::axis::{Points, Warp};
use crate::bake::RoughnessLaw;

pub(super) static TARGET: Target = Target {
    name: "unity-hdrp",
    about: [
        "DDS cube of 256 half floats whose mips 0 to 6 hold the roughness that the pipeline's shaders look up",
        "64x64 table of bias, scale + bias and Disney's diffuse term over sqrt(n.v) and roughness, both limits included; ltc_ggx",
    ],
    source: "Unity Graphics: ImageBasedLighting.hlsl, PreIntegratedFGD.hlsl, preIntegratedFGD_GGXDisneyDiffuse.shader, BSDF.hlsl, LTCAreaLight.hlsl",
    tables: &[
        TablePreset {
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
        },
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
