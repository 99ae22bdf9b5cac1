//! three.js: a cube with mips in the place of what PMREMGenerator makes, and the table of DFGLUTData.js.

use super::{EnvironmentPreset, Mips, TablePreset, Target};
use crate::axis::Warp;
use crate::bake::RoughnessLaw;

pub(super) static TARGET: Target = Target {
    name: "three",
    about: [
        "KTX2 cube of 256, roughness 1 - sqrt(1 - m/M) down to 8 texels; 16x16 table with roughness along x as JavaScript",
        "The last mip is the irradiance too; three.js mirrors cubes that it loads, so the file's +X shows -X",
    ],
    source: "three.js: PMREMGenerator.js, cube_uv_reflection_fragment.glsl.js, WebGLMaterials.js, DFGLUTData.js",
    tables: &[TablePreset {
        size: (16, 16),
        axes: &[Warp::Roughness, Warp::NDotV],
        stem: "dfg_lut",
        extension: "js",
        snippet: "// The half floats of {file} take the place of the array in three's DFGLUTData.js
import { DATA } from './{file}';",
        ..TablePreset::SPLIT_SUM
    }],
    environment: Some(EnvironmentPreset {
        mips: Mips::DownTo(8),
        law: RoughnessLaw::Quadratic,
        file_axes: "-x,y,z",
        snippet: "const ktx2 = new KTX2Loader().setTranscoderPath('basis/').detectSupport(renderer);
const environment = await ktx2.loadAsync('{file}');
environment.isPMREMTexture = true; // already filtered
scene.environment = environment;
scene.background = environment;",
        ..EnvironmentPreset::CUBE
    }),
};
