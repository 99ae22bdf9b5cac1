// SPDX-License-Identifier: MIT OR Apache-2.0
// Khronos' glTF Sample Renderer: the spheres with maps and table of brdf-baker, and with those that it makes at run time.
import { GltfState, GltfView } from "/npm/@khronosgroup/gltf-viewer/dist/gltf-viewer.module.js";
import { spheres } from "./glb.mjs";
import { fromTheTop, json, LOOKS, script, send, url } from "./page.mjs";

// Far away: the shader takes the view from the camera's place even where there is no perspective.
const AWAY = 1e4;

// What the renderer calls an environment, of files instead of its own filter.
async function environmentOf(view, specular, diffuse, lut) {
  const gl = view.context;
  const maps = await Promise.all([specular, diffuse].map(file => view.ktxDecoder.loadKtxFromUri(file)));
  const table = gl.createTexture();
  const picture = new Image();
  picture.src = lut;
  await picture.decode();
  gl.bindTexture(gl.TEXTURE_2D, table);
  gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA8, gl.RGBA, gl.UNSIGNED_BYTE, picture);
  for (const axis of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T]) gl.texParameteri(gl.TEXTURE_2D, axis, gl.CLAMP_TO_EDGE);
  gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.LINEAR);
  const mipCount = maps.map(map => {
    gl.bindTexture(gl.TEXTURE_CUBE_MAP, map);
    gl.texParameteri(gl.TEXTURE_CUBE_MAP, gl.TEXTURE_MIN_FILTER, gl.LINEAR_MIPMAP_LINEAR);
    return gl.getTexParameter(gl.TEXTURE_CUBE_MAP, gl.TEXTURE_MAX_LEVEL) + 1;
  })[0];
  const [cube, flat] = [gl.TEXTURE_CUBE_MAP, gl.TEXTURE_2D];
  return {
    images: [{}],
    textures: [[cube, maps[0]], [cube, maps[1]], [flat, table]].map(([type, glTexture]) => ({ type, glTexture, source: 0, initialized: true })),
    specularEnvMap: { index: 0 }, diffuseEnvMap: { index: 1 }, lut: { index: 2 },
    sheenEnvMap: { index: 0 }, sheenLUT: { index: 2 }, sheenELUT: { index: 2 },
    mipCount, iblIntensityScale: 1,
  };
}

// A camera at `eye` that looks along `towards`: its axes and place, column by column.
function placed(eye, towards, up) {
  const [[x, y, z], [a, b, c]] = [towards, up];
  const right = [y * c - z * b, z * a - x * c, x * b - y * a];
  return [...right, 0, ...up, 0, ...towards.map(c => -c), 0, ...eye, 1];
}

export default async function draw() {
  await script("/npm/@khronosgroup/gltf-viewer/dist/libs/libktx.js");
  const canvas = document.createElement("canvas");
  const gl = canvas.getContext("webgl2");
  gl.getExtension("EXT_color_buffer_float");
  const view = new GltfView(gl);
  // Nothing here is compressed by Draco, but the loader insists on its module.
  const loader = view.createResourceLoader(() => {}, undefined, "/npm/@khronosgroup/gltf-viewer/dist/libs/");
  await view.ktxDecoder.initializied;

  // The renderer draws into the canvas, which has 8 bits: let it draw into floats.
  const bind = gl.bindFramebuffer.bind(gl);
  let target = null;
  gl.bindFramebuffer = (which, framebuffer) => bind(which, framebuffer ?? target);
  function render(state, width, height) {
    target = gl.createFramebuffer();
    const [colour, depth] = [gl.createRenderbuffer(), gl.createRenderbuffer()];
    bind(gl.FRAMEBUFFER, target);
    gl.bindRenderbuffer(gl.RENDERBUFFER, colour);
    gl.renderbufferStorage(gl.RENDERBUFFER, gl.RGBA32F, width, height);
    gl.framebufferRenderbuffer(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.RENDERBUFFER, colour);
    gl.bindRenderbuffer(gl.RENDERBUFFER, depth);
    gl.renderbufferStorage(gl.RENDERBUFFER, gl.DEPTH_COMPONENT24, width, height);
    gl.framebufferRenderbuffer(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, gl.RENDERBUFFER, depth);
    view.renderFrame(state, width, height);
    const pixels = new Float32Array(4 * width * height);
    bind(gl.FRAMEBUFFER, target);
    gl.readPixels(0, 0, width, height, gl.RGBA, gl.FLOAT, pixels);
    gl.deleteFramebuffer(target);
    gl.deleteRenderbuffer(colour);
    gl.deleteRenderbuffer(depth);
    target = null;
    // Without a tone curve there is still a power.
    return fromTheTop(pixels.map(value => Math.pow(Math.max(value, 0), 2.2)), width);
  }

  async function stateOf(layout) {
    const state = view.createState();
    Object.assign(state.renderingParameters, {
      clearColor: [0, 0, 0, 1], usePunctual: false, toneMap: GltfState.ToneMaps.NONE, blurEnvironmentMap: false,
      environmentRotation: 0,
    });
    state.gltf = await loader.loadGltf(spheres(layout, 128).buffer);
    return state;
  }

  function front(state, layout) {
    const [columns, rows] = layout.tiles;
    state.renderingParameters.renderEnvironmentMap = false;
    Object.assign(state.userCamera, { type: "orthographic", transform: placed([0, 0, AWAY], [0, 0, -1], [0, 1, 0]) });
    Object.assign(state.userCamera.orthographic, { xmag: columns / 2, ymag: rows / 2, znear: AWAY - 5, zfar: AWAY + 5 });
    return render(state, ...layout.size_px);
  }

  // As the file has it, and turned by a quarter, which is the renderer's default.
  const lights = await json("lights.json");
  const lit = await stateOf(lights);
  lit.environment = await environmentOf(view, url("gltf-lights_specular.ktx2"), url("gltf-lights_lambertian.ktx2"), url("gltf-lut.png"));
  for (const [name, environmentRotation] of [["", 0], ["-turned", 90]]) {
    Object.assign(lit.renderingParameters, { environmentRotation });
    await send(`gltf-lights${name}.f32`, front(lit, lights));
    lit.renderingParameters.renderEnvironmentMap = true;
    const seen = LOOKS.flatMap(([towards, up]) => {
      // Beyond the spheres, where nothing stands before the background.
      const eye = towards.map(c => 100 * c);
      Object.assign(lit.userCamera, { type: "perspective", transform: placed(eye, towards, up) });
      lit.userCamera.perspective.yfov = Math.PI / 3;
      return [...render(lit, 16, 16).subarray(4 * (16 * 8 + 8), 4 * (16 * 8 + 9))];
    });
    await send(`gltf-background${name}.f32`, new Float32Array(seen));
  }

  const layout = await json("spheres.json");
  const state = await stateOf(layout);
  const ours = await environmentOf(view, url("gltf-sky_specular.ktx2"), url("gltf-sky_lambertian.ktx2"), url("gltf-lut.png"));
  const own = await loader.loadEnvironment(url("gltf-sky.hdr"), { lut_sheen_E_file: url("gltf-lut.png") });
  const lut = own.images[own.textures[own.lut.index].source].image;
  const table = { ...ours, textures: ours.textures.with(ours.lut.index, { ...ours.textures[ours.lut.index], glTexture: lut }) };
  for (const [name, environment] of Object.entries({ ours, table, own })) {
    state.environment = environment;
    await send(`gltf-${name}.f32`, front(state, layout));
  }
}
