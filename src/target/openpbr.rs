//! OpenPBR: the energy tables of Adobe's openpbr-bsdf, which store what single scattering loses.

use super::{TablePreset, Target};
use crate::axis::{Points, Warp};

pub(super) static TARGET: Target = Target {
    name: "openpbr",
    about: [
        "C tables of 16-bit integers over n.v and sqrt(alpha), both limits included: 1 - albedo, 32x32, and its average, 32",
        "They are complements: what single scattering of a metal loses, which multiple scattering gives back",
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
    ],
    environment: None,
};
