// SPDX-License-Identifier: MIT OR Apache-2.0
// MaterialX: a surface of its shader generator with maps and table of brdf-baker, and with those that its own shaders make.
import { sphere } from "./glb.mjs";
import { bytes, fromTheTop, json, send } from "./page.mjs";

// Far away: the shader takes the view from the camera's place even where there is no perspective.
const AWAY = 1e4;
// Rows of the panorama that MaterialX filters itself; it makes maps as large as what it is given.
const OWN_ROWS = 128;
// Where a direction lies in the environment, column by column, so that +X shows +X: the generator's own matrix turns it.
const UPRIGHT = [0, 0, -1, 0, 0, 1, 0, 0, 1, 0, 0, 0, 0, 0, 0, 1];

export default async function draw() {
  const made = await json("materialx.json");
  const gl = document.createElement("canvas").getContext("webgl2");
  for (const name of ["EXT_color_buffer_float", "OES_texture_float_linear"]) {
    if (!gl.getExtension(name)) throw new Error(`no ${name}`);
  }

  function program(pixel) {
    const linked = gl.createProgram();
    for (const [kind, source] of [[gl.VERTEX_SHADER, made.vertex], [gl.FRAGMENT_SHADER, pixel]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, source);
      gl.compileShader(shader);
      if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader));
      gl.attachShader(linked, shader);
    }
    gl.linkProgram(linked);
    if (!gl.getProgramParameter(linked, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(linked));
    const set = {
      float: (at, [v]) => gl.uniform1f(at, v), integer: (at, [v]) => gl.uniform1i(at, v), boolean: (at, [v]) => gl.uniform1i(at, v),
      vector2: (at, v) => gl.uniform2fv(at, v), vector3: (at, v) => gl.uniform3fv(at, v), color3: (at, v) => gl.uniform3fv(at, v),
      matrix44: (at, v) => gl.uniformMatrix4fv(at, false, v),
    };
    const uniform = (name, type, ...values) => set[type](gl.getUniformLocation(linked, name), values);
    gl.useProgram(linked);
    // What the generator says of its ports; the environment's matrix is among them.
    for (const [name, [type, value]] of Object.entries(made.ports)) {
      uniform(name, type, ...value.split(",").map(word => word.trim() === "true" ? 1 : Number(word) || 0));
    }
    return { linked, uniform };
  }

  function texture(unit, mips, repeat) {
    const at = gl.createTexture();
    gl.activeTexture(gl.TEXTURE0 + unit);
    gl.bindTexture(gl.TEXTURE_2D, at);
    gl.texStorage2D(gl.TEXTURE_2D, mips.length, gl.RGBA32F, ...mips[0].size);
    mips.forEach(({ size, data }, level) => {
      if (data) gl.texSubImage2D(gl.TEXTURE_2D, level, 0, 0, ...size, gl.RGBA, gl.FLOAT, data);
    });
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.LINEAR_MIPMAP_LINEAR);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_S, repeat ? gl.REPEAT : gl.CLAMP_TO_EDGE);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE);
    return Object.assign(at, { mips: mips.length, size: mips[0].size });
  }

  // The parts of a file, which are its mips.
  async function load(unit, name, repeat) {
    const floats = new Float32Array(await bytes(`${name}.f32`));
    let at = 0;
    return texture(unit, made.sizes[name].map(size => ({ size, data: floats.subarray(at, at += 4 * size[0] * size[1]) })), repeat);
  }

  const IDENTITY = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1];
  function attribute({ linked }, name, data) {
    const at = gl.getAttribLocation(linked, name);
    if (at < 0) return;
    gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
    gl.bufferData(gl.ARRAY_BUFFER, data, gl.STATIC_DRAW);
    gl.enableVertexAttribArray(at);
    gl.vertexAttribPointer(at, 3, gl.FLOAT, false, 0, 0);
  }

  // One of MaterialX' generators of maps over a whole picture.
  function fill({ uniform, ...used }, target, level, width, height) {
    gl.bindFramebuffer(gl.FRAMEBUFFER, gl.createFramebuffer());
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, target, level);
    gl.viewport(0, 0, width, height);
    gl.disable(gl.DEPTH_TEST);
    attribute(used, "i_position", new Float32Array([-1, -1, 0, 3, -1, 0, -1, 3, 0]));
    uniform("u_worldMatrix", "matrix44", ...IDENTITY);
    uniform("u_viewProjectionMatrix", "matrix44", ...IDENTITY);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
  }

  function ownTable() {
    const used = program(made.table);
    const table = texture(2, [{ size: [64, 64] }], false);
    used.uniform("u_albedoTableSize", "integer", 64);
    fill(used, table, 0, 64, 64);
    return table;
  }

  async function ownMaps() {
    const [width, height] = made.sizes.sky[0];
    const shrink = height / OWN_ROWS;
    const source = new Float32Array(await bytes("sky.f32"));
    // Each texel the mean of those it covers.
    const small = new Float32Array(4 * width * height / shrink ** 2);
    for (let y = 0; y < height; y++) {
      for (let x = 0; x < width; x++) {
        const to = 4 * (Math.floor(y / shrink) * width / shrink + Math.floor(x / shrink));
        for (let c = 0; c < 4; c++) small[to + c] += source[4 * (y * width + x) + c] / shrink ** 2;
      }
    }
    const size = level => [Math.max(2 * OWN_ROWS >> level, 1), Math.max(OWN_ROWS >> level, 1)];
    const levels = Array.from({ length: Math.log2(2 * OWN_ROWS) + 1 }, (_, level) => ({ size: size(level) }));
    texture(0, [{ ...levels[0], data: small }, ...levels.slice(1)], true);
    gl.generateMipmap(gl.TEXTURE_2D);
    const used = program(made.prefilter);
    const filtered = texture(3, levels, true);
    used.uniform("u_envRadiance", "integer", 0);
    used.uniform("u_envRadianceMips", "integer", levels.length);
    levels.forEach(({ size }, level) => {
      used.uniform("u_envPrefilterMip", "integer", level);
      fill(used, filtered, level, ...size);
    });
    return filtered;
  }

  function picture(layout, radiance, irradiance, table, turn) {
    const [columns, rows] = layout.tiles, [width, height] = layout.size_px;
    const used = program(made.surface);
    [radiance, irradiance, table].forEach((map, unit) => {
      gl.activeTexture(gl.TEXTURE0 + unit);
      gl.bindTexture(gl.TEXTURE_2D, map);
      used.uniform(["u_envRadiance", "u_envIrradiance", "u_albedoTable"][unit], "integer", unit);
    });
    used.uniform("u_envRadianceMips", "integer", radiance.mips);
    if (turn) used.uniform("u_envMatrix", "matrix44", ...turn);
    used.uniform("u_viewPosition", "vector3", 0, 0, AWAY);
    used.uniform("u_viewProjectionMatrix", "matrix44", 2 / columns, 0, 0, 0, 0, 2 / rows, 0, 0, 0, 0, -0.1, 0, 0, 0, 0, 1);
    used.uniform("u_worldInverseTransposeMatrix", "matrix44", ...IDENTITY);

    const [colour, depth] = [gl.createRenderbuffer(), gl.createRenderbuffer()];
    gl.bindFramebuffer(gl.FRAMEBUFFER, gl.createFramebuffer());
    gl.bindRenderbuffer(gl.RENDERBUFFER, colour);
    gl.renderbufferStorage(gl.RENDERBUFFER, gl.RGBA32F, width, height);
    gl.framebufferRenderbuffer(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.RENDERBUFFER, colour);
    gl.bindRenderbuffer(gl.RENDERBUFFER, depth);
    gl.renderbufferStorage(gl.RENDERBUFFER, gl.DEPTH_COMPONENT24, width, height);
    gl.framebufferRenderbuffer(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, gl.RENDERBUFFER, depth);
    gl.viewport(0, 0, width, height);
    gl.enable(gl.DEPTH_TEST);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);

    const { normals, indices } = sphere(128);
    attribute(used, "i_position", normals);
    attribute(used, "i_normal", normals);
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, gl.createBuffer());
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, indices, gl.STATIC_DRAW);
    for (const { centre, colour, metallic, roughness } of layout.spheres) {
      const r = layout.radius;
      used.uniform("u_worldMatrix", "matrix44", r, 0, 0, 0, 0, r, 0, 0, 0, 0, r, 0, ...centre, 0, 1);
      used.uniform("top_color0", "color3", ...(metallic ? colour : [0.04, 0.04, 0.04]));
      used.uniform("base_color", "color3", ...(metallic ? [0, 0, 0] : colour));
      used.uniform("top_roughness", "vector2", roughness ** 2, roughness ** 2);
      gl.drawElements(gl.TRIANGLES, indices.length, gl.UNSIGNED_SHORT, 0);
    }
    const pixels = new Float32Array(4 * width * height);
    gl.readPixels(0, 0, width, height, gl.RGBA, gl.FLOAT, pixels);
    const error = gl.getError();
    if (error) throw new Error(`WebGL reports error ${error}`);
    return fromTheTop(pixels, width);
  }

  const table = await load(2, "materialx-table", false);
  const maps = async name => [await load(0, `materialx-${name}_specular`, true), await load(1, `materialx-${name}_irradiance`, true)];
  await send("materialx-lights.f32", picture(await json("lights.json"), ...await maps("lights"), table));
  const layout = await json("spheres.json");
  const [radiance, irradiance] = await maps("sky");
  await send("materialx-ours.f32", picture(layout, radiance, irradiance, table, UPRIGHT));
  const own = ownTable();
  await send("materialx-ours-but-table.f32", picture(layout, radiance, irradiance, own, UPRIGHT));
  await send("materialx-own.f32", picture(layout, await ownMaps(), irradiance, own, UPRIGHT));
}
