// SPDX-License-Identifier: MIT OR Apache-2.0
// Babylon.js: six lights in a .env of brdf-baker, and in what Babylon filters from the panorama; in its own left-handed
// world and in a right-handed one.
import { fromTheTop, json, LOOKS, script, send, url } from "./page.mjs";

export default async function draw() {
  await script("/npm/babylonjs/babylon.js");
  const engine = new BABYLON.Engine(document.createElement("canvas"), false);
  const lights = await json("lights.json");
  const prefiltered = file => scene => BABYLON.CubeTexture.CreateFromPrefilteredData(url(file), scene);

  function ready(texture) {
    return new Promise((resolve, reject) => {
      if (texture.isReady()) resolve(texture);
      texture.onLoadObservable.addOnce(() => resolve(texture));
      setTimeout(() => reject(new Error(`${texture.name} does not load`)), 100_000);
    });
  }

  // Radiance as it is, into a float texture.
  async function render(scene, camera, width, height) {
    const target = new BABYLON.RenderTargetTexture("target", { width, height }, scene, {
      type: BABYLON.Constants.TEXTURETYPE_FLOAT, generateMipMaps: false,
    });
    target.activeCamera = camera;
    target.renderList = scene.meshes;
    scene.customRenderTargets = [target];
    scene.activeCamera = camera;
    await scene.whenReadyAsync(true);
    scene.render();
    scene.render();
    const pixels = await target.readPixels();
    target.dispose();
    return new Float32Array(pixels);
  }

  async function picture(name, layout, texture, table, rightHanded) {
    const scene = new BABYLON.Scene(engine);
    scene.useRightHandedSystem = rightHanded;
    scene.clearColor = new BABYLON.Color4(0, 0, 0, 1);
    // No curve and no sRGB: that would be the post-process's work.
    scene.imageProcessingConfiguration.applyByPostProcess = true;
    scene.environmentTexture = await ready(texture(scene));
    if (table) {
      // Before the first material: each takes the scene's table when it is made.
      const brdf = new BABYLON.Texture(url("babylon_brdf.png"), scene, true, false, BABYLON.Texture.BILINEAR_SAMPLINGMODE);
      brdf.isRGBD = true;
      brdf.wrapU = brdf.wrapV = BABYLON.Texture.CLAMP_ADDRESSMODE;
      scene.environmentBRDFTexture = await ready(brdf);
      // To half floats, as the engine does with its own: an encoded texel must not be blended with its neighbour.
      BABYLON.RGBDTextureTools.ExpandRGBDTexture(brdf);
    }
    // In a left-handed world the viewer looks along +Z, in a right-handed one along -Z.
    const towards = rightHanded ? 1 : -1;
    for (const { centre, colour, metallic, roughness } of layout.spheres) {
      const mesh = BABYLON.MeshBuilder.CreateSphere("sphere", { diameter: 2 * layout.radius, segments: 64 }, scene);
      mesh.position.set(centre[0], centre[1], 0);
      mesh.material = new BABYLON.PBRMaterial("material", scene);
      mesh.material.albedoColor = new BABYLON.Color3(...colour);
      mesh.material.metallic = metallic;
      mesh.material.roughness = roughness;
    }
    // Far away: the shader takes the view from the camera's place even where there is no perspective.
    const camera = new BABYLON.FreeCamera("camera", new BABYLON.Vector3(0, 0, 1000 * towards), scene);
    camera.setTarget(BABYLON.Vector3.Zero());
    camera.mode = BABYLON.Camera.ORTHOGRAPHIC_CAMERA;
    const [columns, rows] = layout.tiles, [width, height] = layout.size_px;
    [camera.orthoLeft, camera.orthoRight, camera.orthoBottom, camera.orthoTop] = [-columns / 2, columns / 2, -rows / 2, rows / 2];
    camera.minZ = 900;
    camera.maxZ = 1100;
    await send(`${name}.f32`, fromTheTop(await render(scene, camera, width, height), width));

    scene.meshes.slice().forEach(mesh => mesh.dispose());
    scene.createDefaultSkybox(scene.environmentTexture, true, 100, 0, false);
    const seen = [];
    for (const [at, up] of LOOKS) {
      // The picture's right, up and viewer are +X, +Y and the viewer's side of Z in either world.
      const flip = v => new BABYLON.Vector3(v[0], v[1], v[2] * towards);
      const look = new BABYLON.FreeCamera("look", BABYLON.Vector3.Zero(), scene);
      look.upVector = flip(up);
      look.setTarget(flip(at));
      seen.push(...(await render(scene, look, 16, 16)).subarray(4 * (16 * 8 + 8), 4 * (16 * 8 + 9)));
    }
    await send(`${name}-background.f32`, new Float32Array(seen));
    scene.dispose();
  }

  for (const [hand, rightHanded] of [["left", false], ["right", true]]) {
    const panorama = scene => new BABYLON.HDRCubeTexture(url("lights.hdr"), scene, 128, false, true, false, true);
    await picture(`babylon-${hand}-ours`, lights, prefiltered("lights.env"), true, rightHanded);
    await picture(`babylon-${hand}-own`, lights, panorama, false, rightHanded);
  }
  // The same maps with either table.
  const spheres = await json("spheres.json");
  await picture("babylon-table-ours", spheres, prefiltered("lights.env"), true, false);
  await picture("babylon-table-own", spheres, prefiltered("lights.env"), false, false);
}
