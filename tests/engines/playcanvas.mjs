// SPDX-License-Identifier: MIT OR Apache-2.0
// PlayCanvas: six lights in an atlas of brdf-baker, and in the one that the engine makes from the panorama.
import * as pc from "playcanvas";
import { fromTheTop, json, LOOKS, send, url } from "./page.mjs";

export default async function draw() {
  const layout = await json("lights.json");
  const canvas = document.createElement("canvas");
  const app = new pc.Application(canvas, { graphicsDeviceOptions: { antialias: false } });
  app.autoRender = false;
  app.scene.ambientLight = new pc.Color(0, 0, 0);
  app.start();

  function load(name, data) {
    const asset = new pc.Asset(name, "texture", { url: url(name) }, data);
    app.assets.add(asset);
    return new Promise((resolve, reject) => {
      asset.ready(() => resolve(asset.resource));
      asset.on("error", reject);
      app.assets.load(asset);
    });
  }

  for (const { centre, colour, metallic, roughness } of layout.spheres) {
    const material = new pc.StandardMaterial();
    material.useMetalness = true;
    material.metalness = metallic;
    material.diffuse = new pc.Color(...colour);
    material.gloss = 1 - roughness;
    material.update();
    const mesh = pc.Mesh.fromGeometry(app.graphicsDevice,
      new pc.SphereGeometry({ radius: layout.radius, latitudeBands: 64, longitudeBands: 128 }));
    const entity = new pc.Entity();
    entity.addComponent("render", { meshInstances: [new pc.MeshInstance(mesh, material)] });
    entity.setPosition(...centre, 0);
    app.root.addChild(entity);
  }

  // Radiance as it is.
  async function render(entity, width, height, layers) {
    const colorBuffer = new pc.Texture(app.graphicsDevice, {
      width, height, format: pc.PIXELFORMAT_RGBA32F, mipmaps: false,
      minFilter: pc.FILTER_NEAREST, magFilter: pc.FILTER_NEAREST,
    });
    const renderTarget = new pc.RenderTarget({ colorBuffer, depth: true });
    Object.assign(entity.camera, {
      renderTarget, layers, clearColor: new pc.Color(0, 0, 0, 1),
      toneMapping: pc.TONEMAP_LINEAR, gammaCorrection: pc.GAMMA_NONE,
    });
    app.root.addChild(entity);
    for (let frame = 0; frame < 3; frame++) {
      app.renderNextFrame = true;
      app.tick(performance.now());
      await new Promise(requestAnimationFrame);
    }
    const pixels = await colorBuffer.read(0, 0, width, height, { renderTarget, immediate: true });
    entity.destroy();
    renderTarget.destroy();
    colorBuffer.destroy();
    return fromTheTop(new Float32Array(pixels.buffer, pixels.byteOffset, 4 * width * height), width);
  }

  async function pictures(name, atlas) {
    app.scene.envAtlas = atlas;
    const [columns, rows] = layout.tiles, [width, height] = layout.size_px;
    const front = new pc.Entity();
    // Far away: the shader takes the view from the camera's place even where there is no perspective.
    front.addComponent("camera", {
      projection: pc.PROJECTION_ORTHOGRAPHIC, orthoHeight: rows / 2, nearClip: 900, farClip: 1100, aspectRatio: columns / rows,
    });
    front.setPosition(0, 0, 1000);
    await send(`${name}.f32`, await render(front, width, height, [pc.LAYERID_WORLD]));
    const seen = [];
    for (const [towards, up] of LOOKS) {
      const look = new pc.Entity();
      look.addComponent("camera", { fov: 60, nearClip: 0.1, farClip: 100 });
      look.lookAt(new pc.Vec3(...towards), new pc.Vec3(...up));
      seen.push(...(await render(look, 16, 16, [pc.LAYERID_SKYBOX])).subarray(4 * (16 * 8 + 8), 4 * (16 * 8 + 9)));
    }
    await send(`${name}-background.f32`, new Float32Array(seen));
  }

  await pictures("playcanvas-ours", await load("lights_atlas.png", { type: pc.TEXTURETYPE_RGBP, mipmaps: false }));
  const panorama = await load("lights.hdr", { mipmaps: false });
  panorama.projection = pc.TEXTUREPROJECTION_EQUIRECT;
  await pictures("playcanvas-own", pc.EnvLighting.generateAtlas(pc.EnvLighting.generateLightingSource(panorama)));
}
