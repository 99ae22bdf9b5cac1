// SPDX-License-Identifier: MIT OR Apache-2.0
//! PlayCanvas: one picture, the environment atlas, holds every level; the split-sum factor is a formula of the engine.

use super::{EnvironmentPreset, Mips, TablePreset, Target};
use crate::bake::{RoughnessLaw, atlas};

/// The engine rounds them to halves itself.
const AREA_LIGHTS: &str = "import { LTC_MAT_1 } from './ltc_mat_1.js';
import { LTC_MAT_2 } from './ltc_mat_2.js';
app.setAreaLightLuts(LTC_MAT_1, LTC_MAT_2);";

pub(super) static TARGET: Target = Target {
    name: "playcanvas",
    about: [
        "Environment atlas, 512x512 PNG as RGBP: sharp levels, six levels of GGX and the irradiance in one picture",
        "Takes no split-sum table, its shader has a formula; ltc_mat_1 and ltc_mat_2 for area lights as JavaScript",
    ],
    source: "PlayCanvas: scene/graphics/env-lighting.js, reprojectTexture, chunks lit/frag/envAtlas.js",
    tables: &[
        TablePreset { stem: "ltc_mat_1", extension: "js", encoding: "rgba32f", snippet: AREA_LIGHTS, ..TablePreset::LTC },
        TablePreset {
            stem: "ltc_mat_2",
            extension: "js",
            encoding: "rgba32f",
            snippet: AREA_LIGHTS,
            ..TablePreset::LTC_MAGNITUDE
        },
    ],
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
