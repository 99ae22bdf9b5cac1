//! PlayCanvas: one picture, the environment atlas, holds every level; the split-sum factor is a formula of the engine.

use super::{EnvironmentPreset, Mips, Target};
use crate::bake::{RoughnessLaw, atlas};

pub(super) static TARGET: Target = Target {
    name: "playcanvas",
    about: [
        "Environment atlas, 512x512 PNG as RGBP: sharp levels, six levels of GGX and the irradiance in one picture",
        "Takes no table: the engine's shader has a formula",
    ],
    source: "PlayCanvas: scene/graphics/env-lighting.js, reprojectTexture, chunks lit/frag/envAtlas.js",
    tables: &[],
    environment: Some(EnvironmentPreset {
        shape: atlas::NAME,
        size: atlas::SIDE,
        mips: Mips::AtMost(7),
        law: RoughnessLaw::Playcanvas,
        extension: "png",
        encoding: "rgbp8",
        suffix: "_atlas",
        snippet: "const atlas = new pc.Asset('atlas', 'texture', { url: '{file}' }, { type: pc.TEXTURETYPE_RGBP, mipmaps: false });
app.assets.add(atlas);
atlas.ready(() => { app.scene.envAtlas = atlas.resource; });
app.assets.load(atlas);",
        ..EnvironmentPreset::CUBE
    }),
};
