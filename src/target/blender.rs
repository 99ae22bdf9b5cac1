// SPDX-License-Identifier: MIT OR Apache-2.0
//! Blender: the layouts of Cycles' and EEVEE's tables, and a picture for the world's background.

use super::{EnvironmentPreset, TablePreset, Target};
use crate::axis::{Points, Warp};
use crate::bake::SliceAxis;

/// Over roughness and n·v with both limits, 32 each, as C floats.
const CYCLES: TablePreset = TablePreset {
    size: (32, 32),
    axes: &[Warp::Roughness, Warp::NDotV],
    points: Points::Edges,
    channels: &["albedo"],
    encoding: "r32f",
    ..TablePreset::SPLIT_SUM
};

/// Glass over roughness, n·v and the index, 16 each.
const CYCLES_GLASS: TablePreset = TablePreset {
    table: "glass",
    size: (16, 16),
    slices: Some((SliceAxis::FromF0, 16)),
    channels: &["total"],
    stem: "ggx_glass_E",
    extension: "h",
    snippet: "// {file}: slice = z with F0 = z^4, row = n.v, column = roughness
// lookup_table_read_3D(roughness, mu, sqrtf(fabsf((ior - 1) / (ior + 1))), offset, 16, 16, 16)",
    ..CYCLES
};

/// Its averages over roughness and the index.
const CYCLES_GLASS_AVERAGE: TablePreset = TablePreset {
    table: "glass-average",
    size: (16, 1),
    axes: &[Warp::Roughness],
    stem: "ggx_glass_Eavg",
    snippet: "// {file}: row = z with F0 = z^4, column = roughness
// lookup_table_read_2D(roughness, sqrtf(fabsf((ior - 1) / (ior + 1))), offset, 16, 16)",
    ..CYCLES_GLASS
};

/// Weights of F90 over roughness, n·v and the exponent, 16 each.
const CYCLES_SCHLICK: TablePreset = TablePreset {
    table: "schlick-weight",
    slices: Some((SliceAxis::CyclesExponent, 16)),
    channels: &["weight"],
    stem: "ggx_gen_schlick_s",
    snippet: "// {file}: slice = z with exponent 5 (1 - z)/z, row = n.v, column = roughness
// s = lookup_table_read_3D(roughness, mu, 1 / (0.2f * exponent + 1), offset, 16, 16, 16)",
    ..CYCLES_GLASS
};

/// Sheen over n·v and alpha, 32 each: a plane for A, for B and for the albedo.
const CYCLES_SHEEN: TablePreset = TablePreset {
    table: "ltc-sheen-volume",
    axes: &[Warp::NDotV, Warp::Alpha],
    channels: &["a", "b", "reflectance"],
    planes: true,
    stem: "sheen_ltc",
    extension: "h",
    encoding: "rgba32f",
    snippet: "// {file}: planes of A, B and the albedo, row = roughness, column = n.v
// lookup_table_read_2D(mu, roughness, offset + plane * 32 * 32, 32, 32)",
    ..CYCLES
};

pub(super) static TARGET: Target = Target {
    name: "blender",
    about: [
        "EXR picture of 2048x1024 for a world's environment texture",
        "Tables as C: EEVEE's brdf_ggx (split-sum), ltc_mat_ggx, ltc_mag_ggx; Cycles' ggx_E, ggx_Eavg, ggx_glass_*, ggx_gen_schlick_*, sheen_ltc, by name",
    ],
    source: "Blender: Cycles scene/shader.tables, app/cycles_precompute.cpp; EEVEE eevee_lut",
    tables: &[
        TablePreset {
            size: (64, 64),
            axes: &[Warp::Roughness, Warp::SqrtOneMinusNDotV],
            points: Points::Edges,
            stem: "brdf_ggx",
            extension: "h",
            encoding: "rg32f",
            snippet: "vec2 uv = vec2(roughness, sqrt(clamp(1.0 - cos_theta, 0.0, 1.0))); // {file}
vec2 split_sum = texture(utility_tx, uv * 63.0 / 64.0 + 0.5 / 64.0).rg;",
            ..TablePreset::SPLIT_SUM
        },
        TablePreset {
            table: "albedo",
            stem: "ggx_E",
            extension: "h",
            snippet: "// {file}: row = n.v, column = roughness; lookup_table_read_2D(roughness, mu, offset, 32, 32)",
            ..CYCLES
        },
        TablePreset {
            table: "average-albedo",
            size: (32, 1),
            axes: &[Warp::Roughness],
            stem: "ggx_Eavg",
            extension: "h",
            channels: &["average"],
            snippet: "// {file}: lookup_table_read(roughness, offset, 32)",
            ..CYCLES
        },
        TablePreset {
            stem: "ltc_mat_ggx",
            extension: "h",
            encoding: "rgba32f",
            snippet: "// {file}: EEVEE's utility texture, layer of the matrix",
            ..TablePreset::LTC
        },
        TablePreset {
            channels: &["magnitude", "fresnel"],
            stem: "ltc_mag_ggx",
            extension: "h",
            encoding: "rg32f",
            snippet: "// {file}: EEVEE's utility texture, layer of the magnitude",
            ..TablePreset::LTC_MAGNITUDE
        },
        CYCLES_GLASS,
        CYCLES_GLASS_AVERAGE,
        TablePreset { slices: Some((SliceAxis::InverseFromF0, 16)), stem: "ggx_glass_inv_E", ..CYCLES_GLASS },
        TablePreset {
            slices: Some((SliceAxis::InverseFromF0, 16)),
            stem: "ggx_glass_inv_Eavg",
            ..CYCLES_GLASS_AVERAGE
        },
        CYCLES_SCHLICK,
        TablePreset {
            slices: Some((SliceAxis::FromF0, 16)),
            stem: "ggx_gen_schlick_ior_s",
            snippet: "// {file}: slice = z with F0 = z^4, row = n.v, column = roughness
// s = lookup_table_read_3D(roughness, mu, sqrtf(fabsf((ior - 1) / (ior + 1))), offset, 16, 16, 16)",
            ..CYCLES_SCHLICK
        },
        CYCLES_SHEEN,
    ],
    environment: Some(EnvironmentPreset {
        snippet: "import bpy
world = bpy.context.scene.world
world.use_nodes = True
texture = world.node_tree.nodes.new('ShaderNodeTexEnvironment')
texture.image = bpy.data.images.load('{file}')
world.node_tree.links.new(texture.outputs['Color'], world.node_tree.nodes['Background'].inputs['Color'])",
        ..EnvironmentPreset::EQUIRECT
    }),
};
