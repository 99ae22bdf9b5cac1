// SPDX-License-Identifier: MIT OR Apache-2.0
//! glTF: the Khronos sample viewer and what glTF-IBL-Sampler writes for it.

use super::{Beside, Content, EnvironmentPreset, Mips, TablePreset, Target};

pub(super) static TARGET: Target = Target {
    name: "gltf",
    about: [
        "KTX2 cube of 512 half floats, roughness m/M down to 4 texels, with a 256 cube of irradiance over pi beside it",
        "1024x1024 table of scale, bias and cloth as 8-bit PNG, as glTF-IBL-Sampler writes it",
    ],
    source: "KhronosGroup: glTF-IBL-Sampler (lib.cpp, filter.frag), glTF-Sample-Viewer (ibl.glsl)",
    tables: &[TablePreset {
        size: (1024, 1024),
        stem: "lut_ggx",
        extension: "png",
        encoding: "rgb8unorm",
        snippet:
            "vec2 f_ab = texture(u_GGXLUT, vec2(NdotV, perceptualRoughness)).rg; // {file}: linear, clamped, no mips
vec3 specular = specularLight * (F0 * f_ab.x + f_ab.y);",
        ..TablePreset::SPLIT_SUM
    }],
    environment: Some(EnvironmentPreset {
        // Down to one texel, a metal of roughness 1 would be off by 8.5 %, like this by 1.2 %: the viewer interpolates evenly in
        // roughness. 512 texels and not 256, so that as many mips are left.
        size: 512,
        mips: Mips::DownTo(4),
        beside: &[Beside { content: Content::Diffuse, size: Some(256), suffix: "_lambertian" }],
        snippet: "// {file} is u_GGXEnvSampler, {diffuse} is u_LambertianEnvSampler
float lod = perceptualRoughness * float(u_MipCount - 1);
vec3 specularLight = textureLod(u_GGXEnvSampler, reflection, lod).rgb;
vec3 diffuseLight = texture(u_LambertianEnvSampler, normal).rgb;",
        ..EnvironmentPreset::CUBE
    }),
};
