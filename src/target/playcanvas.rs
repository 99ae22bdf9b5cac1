//! PlayCanvas: one picture, the environment atlas, holds every level; the split-sum factor is a formula of the engine.

use super::{EnvironmentPreset, Mips, Target};
use crate::bake::RoughnessLaw;

pub(super) static TARGET: Target = Target {
    name: "playcanvas",
    about: [
        "Environment atlas, 512x512 PNG as RGBP: sharp levels, six levels of GGX and the irradiance in one picture",
        "Takes no table: the engine's shader has a formula",
    ],
    source: "PlayCanvas: scene/graphics/env-lighting.js, reprojectTexture, chunks lit/frag/envAtlas.js",
    tables: &[],
    environment: Some(EnvironmentPreset {
        shape: "equirect",
        size: 256,
        mips: Mips::Exactly(7),
        law: RoughnessLaw::Playcanvas,
        extension: "ktx2",
        suffix: "_atlas",
        snippet: "",
        ..EnvironmentPreset::CUBE
    }),
};
