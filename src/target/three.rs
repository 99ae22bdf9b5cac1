// SPDX-License-Identifier: MIT OR Apache-2.0
//! three.js: a cube with mips in the place of what PMREMGenerator makes, and the table of DFGLUTData.js.

use super::{EnvironmentPreset, Mips, TablePreset, Target};
use crate::axis::Warp;
use crate::bake::RoughnessLaw;

/// Both tables in the place of those of RectAreaLightTexturesLib.
const AREA_LIGHTS: &str = "import { LTC_MAT_1 } from './ltc_mat_1.js'; // half floats
import { LTC_MAT_2 } from './ltc_mat_2.js';
const texture = halves => {
  const made = new THREE.DataTexture(halves, 64, 64, THREE.RGBAFormat, THREE.HalfFloatType, THREE.UVMapping,
    THREE.ClampToEdgeWrapping, THREE.ClampToEdgeWrapping, THREE.LinearFilter, THREE.NearestFilter, 1);
  made.needsUpdate = true;
  return made;
};
RectAreaLightUniformsLib.init(); // of three/addons/lights
THREE.UniformsLib.LTC_FLOAT_1 = THREE.UniformsLib.LTC_HALF_1 = texture(LTC_MAT_1);
THREE.UniformsLib.LTC_FLOAT_2 = THREE.UniformsLib.LTC_HALF_2 = texture(LTC_MAT_2);";

pub(super) static TARGET: Target = Target {
    name: "three",
    about: [
        "KTX2 cube of 256, roughness 1 - sqrt(1 - m/M) down to 8 texels; 16x16 table with roughness along x as JavaScript; ltc_mat_1, ltc_mat_2",
        "The last mip is the irradiance too; three.js mirrors cubes that it loads, so the file's +X shows -X",
    ],
    source: "three.js: PMREMGenerator.js, cube_uv_reflection_fragment.glsl.js, WebGLMaterials.js, DFGLUTData.js, RectAreaLightTexturesLib.js",
    tables: &[
        TablePreset {
            size: (16, 16),
            axes: &[Warp::Roughness, Warp::NDotV],
            stem: "dfg_lut",
            extension: "js",
            snippet: "import { DFG_LUT } from './{file}'; // half floats, in the place of the array in three's DFGLUTData.js",
            ..TablePreset::SPLIT_SUM
        },
        TablePreset { stem: "ltc_mat_1", extension: "js", snippet: AREA_LIGHTS, ..TablePreset::LTC },
        TablePreset { stem: "ltc_mat_2", extension: "js", snippet: AREA_LIGHTS, ..TablePreset::LTC_MAGNITUDE },
    ],
    environment: Some(EnvironmentPreset {
        mips: Mips::DownTo(8),
        law: RoughnessLaw::Quadratic,
        file_axes: "-x,y,z",
        snippet: "const flat = await new KTX2Loader().detectSupport(renderer).loadAsync('{file}');
const face = i => ({ width: flat.image.width, height: flat.image.height, mipmaps: flat.mipmaps.map(({ data, width, height }) =>
  ({ data: data.subarray(i * data.length / 6, (i + 1) * data.length / 6), width, height })) }); // the loader leaves cubes flat
const cube = new THREE.CompressedCubeTexture([0, 1, 2, 3, 4, 5].map(face), flat.format, flat.type);
cube.minFilter = THREE.LinearMipmapLinearFilter;
cube.magFilter = THREE.LinearFilter;
cube.isPMREMTexture = true; // filtered already
cube.needsUpdate = true;
scene.environment = scene.background = cube;",
        ..EnvironmentPreset::CUBE
    }),
};
