// SPDX-License-Identifier: MIT OR Apache-2.0
//! OpenPBR: the energy tables of Adobe's openpbr-bsdf, which store what single scattering loses.

use super::{TablePreset, Target};
use crate::axis::{Points, Warp};
use crate::bake::SliceAxis;

/// What an interface loses, over cos, √alpha and the index, 32 each.
const DIELECTRIC: TablePreset = TablePreset {
    table: "glass",
    size: (32, 32),
    slices: Some((SliceAxis::Openpbr, 32)),
    points: Points::Edges,
    channels: &["lost"],
    stem: "ideal_dielectric_energy_complement",
    extension: "h",
    encoding: "r16unorm",
    snippet: "// {file}: column = 31 cos, row = 31 sqrt(alpha), slice = openpbr_ior_to_exact_index(ior), value / 65535",
    ..TablePreset::SPLIT_SUM
};

/// Its mean over cos.
const DIELECTRIC_AVERAGE: TablePreset = TablePreset {
    table: "glass-average",
    size: (32, 1),
    axes: &[Warp::Roughness],
    stem: "ideal_dielectric_average_energy_complement",
    snippet: "// {file}: column = 31 sqrt(alpha), row = openpbr_ior_to_exact_index(ior), value / 65535",
    ..DIELECTRIC
};

pub(super) static TARGET: Target = Target {
    name: "openpbr",
    about: [
        "C tables of 16-bit integers over n.v, sqrt(alpha) and the index, limits included, 32 each: of metals 1 - albedo, of",
        "dielectrics 1 - total (ideal) and 1 - reflected (opaque), each with its average; not the reflection ratio",
    ],
    source: "adobe/openpbr-bsdf: openpbr_data_constants.h, openpbr_microfacet_multiple_scattering_data.h",
    tables: &[
        TablePreset {
            table: "albedo",
            size: (32, 32),
            points: Points::Edges,
            channels: &["lost"],
            stem: "ideal_metal_energy_complement",
            extension: "h",
            encoding: "r16unorm",
            snippet: "// {file}: column = 31 cos, row = 31 sqrt(alpha), value / 65535",
            ..TablePreset::SPLIT_SUM
        },
        TablePreset {
            table: "average-albedo",
            size: (32, 1),
            axes: &[Warp::Roughness],
            points: Points::Edges,
            channels: &["lost"],
            stem: "ideal_metal_average_energy_complement",
            extension: "h",
            encoding: "r16unorm",
            snippet: "// {file}: 31 sqrt(alpha), value / 65535",
            ..TablePreset::SPLIT_SUM
        },
        DIELECTRIC,
        DIELECTRIC_AVERAGE,
        TablePreset { channels: &["unreflected"], stem: "opaque_dielectric_energy_complement", ..DIELECTRIC },
        TablePreset {
            channels: &["unreflected"],
            stem: "opaque_dielectric_average_energy_complement",
            ..DIELECTRIC_AVERAGE
        },
    ],
    environment: None,
};
