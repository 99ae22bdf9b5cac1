// SPDX-License-Identifier: MIT OR Apache-2.0
//! Filament: KTX1 cubes as cmgen writes them, and its DFG table.

use super::{Beside, Content, EnvironmentPreset, Mips, TablePreset, Target};
use crate::bake::RoughnessLaw;

/// Filament has no area lights of its own: an unlit material may.
const AREA_LIGHTS: &str =
    "// Both by ktxreader::Ktx1Reader::createTexture, as parameters of a material that lights itself:
vec2 uv = vec2(roughness, sqrt(1.0 - clamp(dot(normal, view), 0.0, 1.0))) * (63.0 / 64.0) + 0.5 / 64.0;
vec4 t1 = texture(materialParams_ltc1, uv);
vec4 t2 = texture(materialParams_ltc2, uv);
mat3 inverse = mat3(vec3(t1.x, 0.0, t1.y), vec3(0.0, 1.0, 0.0), vec3(t1.z, 0.0, t1.w)); // by columns";

pub(super) static TARGET: Target = Target {
    name: "filament",
    about: [
        "KTX1 cube of 256 as b10g11r11, roughness 1 - sqrt(1 - m/M) down to 16 texels, irradiance inside, skybox beside it",
        "128x128 table of bias, scale + bias and cloth as C; its rows lie one texel high, as in today's engine (--exact-rows)",
    ],
    source: "Filament: tools/cmgen, libs/ibl (CubemapIBL.cpp, CubemapSH.cpp), shaders/src/surface_light_indirect.fs",
    tables: &[
        TablePreset {
            // cmgen takes row j at (j + 3/2)/128, and the engine's shader reads it as if it were (j + 1/2)/128.
            row_shift: 1,
            channels: &["bias", "albedo", "cloth"],
            stem: "dfg",
            extension: "h",
            encoding: "rgba16f",
            snippet: "// Part of the engine: the words of {file} take the place of those in filament's generated dfg resource",
            ..TablePreset::SPLIT_SUM
        },
        TablePreset { extension: "ktx", snippet: AREA_LIGHTS, ..TablePreset::LTC },
        TablePreset { extension: "ktx", snippet: AREA_LIGHTS, ..TablePreset::LTC_MAGNITUDE },
    ],
    environment: Some(EnvironmentPreset {
        mips: Mips::DownTo(16),
        law: RoughnessLaw::Quadratic,
        // The middle of the panorama lies along +Z, what is right of it along -X: as cmgen places it, unless asked not to mirror.
        file_axes: "z,y,-x",
        extension: "ktx",
        encoding: "b10g11r11",
        suffix: "_ibl",
        beside: &[Beside { content: Content::Skybox, size: None, suffix: "_skybox" }],
        snippet:
            "const ibl = engine.createIblFromKtx1('{file}'); // JavaScript; C++: ktxreader::Ktx1Reader::createTexture
ibl.setIntensity(30000.0);
scene.setIndirectLight(ibl);
scene.setSkybox(engine.createSkyFromKtx1('{skybox}'));",
        ..EnvironmentPreset::CUBE
    }),
};
