// SPDX-License-Identifier: MIT OR Apache-2.0
//! Babylon.js: `.env` files, and the table that `scene.environmentBRDFTexture` holds.

use super::{EnvironmentPreset, TablePreset, Target};
use crate::bake::RoughnessLaw;

/// Both tables for RectAreaLight.
const AREA_LIGHTS: &str = "import { LTC_MAT_1 } from './ltc_mat_1.js'; // half floats
import { LTC_MAT_2 } from './ltc_mat_2.js';
const { TEXTUREFORMAT_RGBA, TEXTURE_LINEAR_LINEAR, TEXTURETYPE_HALF_FLOAT } = BABYLON.Constants;
const texture = halves => new BABYLON.RawTexture(halves, 64, 64, TEXTUREFORMAT_RGBA, scene.getEngine(), false, false,
  TEXTURE_LINEAR_LINEAR, TEXTURETYPE_HALF_FLOAT);
scene.areaLightLTCProvider = { getTexturesAsync: async () => ({ LTC1: texture(LTC_MAT_1), LTC2: texture(LTC_MAT_2) }) };";

pub(super) static TARGET: Target = Target {
    name: "babylon",
    about: [
        ".env cube of 256 as RGBD with its irradiance inside; 256x256 table of bias, scale + bias and cloth as RGBD PNG",
        "alpha of mip m is 2^(m/0.8)/size, the lodGenerationScale that the file states; ltc_mat_1, ltc_mat_2",
    ],
    source: "@babylonjs/core: environmentTextureTools.ts, hdrFiltering.ts, brdfTextureTools.ts, pbrBRDFFunctions, Lights/LTC/ltcTextureTool",
    tables: &[
        TablePreset {
            size: (256, 256),
            channels: &["bias", "albedo", "cloth"],
            stem: "brdf",
            extension: "png",
            encoding: "rgbd8",
            snippet:
                "const brdf = new BABYLON.Texture('{file}', scene, true, false, BABYLON.Texture.BILINEAR_SAMPLINGMODE);
brdf.isRGBD = true;
brdf.wrapU = brdf.wrapV = BABYLON.Texture.CLAMP_ADDRESSMODE;
brdf.onLoadObservable.addOnce(() => BABYLON.RGBDTextureTools.ExpandRGBDTexture(brdf)); // codes must not be blended
scene.environmentBRDFTexture = brdf; // before the first material",
            ..TablePreset::SPLIT_SUM
        },
        TablePreset { stem: "ltc_mat_1", extension: "js", snippet: AREA_LIGHTS, ..TablePreset::LTC },
        TablePreset { stem: "ltc_mat_2", extension: "js", snippet: AREA_LIGHTS, ..TablePreset::LTC_MAGNITUDE },
    ],
    environment: Some(EnvironmentPreset {
        law: RoughnessLaw::Babylon,
        // In the engine's left-handed world the middle of the panorama lies along +Z, what is right of it along +X: as
        // HDRCubeTexture places it. A right-handed scene looks files up with z reversed.
        file_axes: "z,y,x",
        extension: "env",
        encoding: "rgbd8",
        suffix: "",
        snippet: "scene.environmentTexture = BABYLON.CubeTexture.CreateFromPrefilteredData('{file}', scene);",
        ..EnvironmentPreset::CUBE
    }),
};
