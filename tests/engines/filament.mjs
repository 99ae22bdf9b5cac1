// SPDX-License-Identifier: MIT OR Apache-2.0
// Filament (WebAssembly): six lights in KTX files of brdf-baker, on spheres of a glTF file and behind them.
import { LOOKS, json, script, send, url } from "./page.mjs";

// A binary glTF with one sphere a material. Filament has no other way to a lit material without its compiler.
function spheres(layout) {
  const [rings, segments] = [64, 128];
  const normals = [], indices = [];
  for (let i = 0; i <= rings; i++) {
    for (let j = 0; j <= segments; j++) {
      const [theta, phi] = [Math.PI * i / rings, 2 * Math.PI * j / segments];
      normals.push(Math.sin(theta) * Math.cos(phi), Math.cos(theta), -Math.sin(theta) * Math.sin(phi));
      if (i === rings || j === segments) continue;
      const a = i * (segments + 1) + j, b = a + segments + 1;
      indices.push(a, b, a + 1, a + 1, b, b + 1);
    }
  }
  const places = normals.map(n => n * layout.radius);
  const parts = [new Float32Array(places), new Float32Array(normals), new Uint16Array(indices)];
  let at = 0;
  const views = parts.map(part => ({ buffer: 0, byteOffset: (at += part.byteLength) - part.byteLength, byteLength: part.byteLength }));
  const r = layout.radius;
  const gltf = {
    asset: { version: "2.0" },
    scene: 0,
    scenes: [{ nodes: layout.spheres.map((_, i) => i) }],
    nodes: layout.spheres.map(({ centre }, i) => ({ mesh: i, translation: [...centre, 0] })),
    meshes: layout.spheres.map((_, i) => ({
      primitives: [{ attributes: { POSITION: 0, NORMAL: 1 }, indices: 2, material: i }],
    })),
    materials: layout.spheres.map(({ colour, metallic, roughness }) => ({
      pbrMetallicRoughness: { baseColorFactor: [...colour, 1], metallicFactor: metallic, roughnessFactor: roughness },
    })),
    accessors: [
      { bufferView: 0, componentType: 5126, type: "VEC3", count: normals.length / 3, min: [-r, -r, -r], max: [r, r, r] },
      { bufferView: 1, componentType: 5126, type: "VEC3", count: normals.length / 3 },
      { bufferView: 2, componentType: 5123, type: "SCALAR", count: indices.length },
    ],
    bufferViews: views,
    buffers: [{ byteLength: at }],
  };
  let text = JSON.stringify(gltf);
  text += " ".repeat((4 - text.length % 4) % 4);
  const padding = (4 - at % 4) % 4;
  const file = new Uint8Array(12 + 8 + text.length + 8 + at + padding);
  const words = new DataView(file.buffer);
  const put = (offset, ...values) => values.forEach((value, i) => words.setUint32(offset + 4 * i, value, true));
  put(0, 0x46546c67, 2, file.length, text.length, 0x4e4f534a);
  file.set(new TextEncoder().encode(text), 20);
  put(20 + text.length, at + padding, 0x004e4942);
  parts.forEach((part, i) => file.set(new Uint8Array(part.buffer), 28 + text.length + views[i].byteOffset));
  return file;
}

export default async function draw() {
  await script("/npm/filament/filament.js");
  const [ibl, sky] = [url("filament_ibl.ktx"), url("filament_skybox.ktx")];
  await new Promise(resolve => Filament.init([ibl, sky], resolve));

  const layout = await json("lights.json");
  const canvas = document.createElement("canvas");
  [canvas.width, canvas.height] = layout.size_px;
  document.body.append(canvas);
  const engine = Filament.Engine.create(canvas, { preserveDrawingBuffer: true, antialias: false });
  const scene = engine.createScene();
  const light = engine.createIblFromKtx1(ibl);
  light.setIntensity(1);
  scene.setIndirectLight(light);

  const loader = engine.createAssetLoader();
  const asset = loader.createAsset(spheres(layout));
  await new Promise(resolve => asset.loadResources(resolve, null, null, null));
  scene.addEntities(asset.getRenderableEntities());

  const swapChain = engine.createSwapChain();
  const renderer = engine.createRenderer();
  renderer.setClearOptions({ clearColor: [0, 0, 0, 1], clear: true });
  const camera = engine.createCamera(Filament.EntityManager.get().create());
  camera.setExposureDirect(1);
  const view = engine.createView();
  view.setCamera(camera);
  view.setScene(scene);
  view.setPostProcessingEnabled(false);

  // Linear, in 8 bits: which light it is can be told.
  async function render(width, height) {
    view.setViewport([0, 0, width, height]);
    for (let frame = 0; frame < 4; frame++) {
      renderer.render(swapChain, view);
      engine.execute();
      await new Promise(requestAnimationFrame);
    }
    const copy = new OffscreenCanvas(canvas.width, canvas.height).getContext("2d");
    copy.drawImage(canvas, 0, 0);
    return Float32Array.from(copy.getImageData(0, canvas.height - height, width, height).data, value => value / 255);
  }

  const [columns, rows] = layout.tiles;
  camera.setProjection(Filament.Camera$Projection.ORTHO, -columns / 2, columns / 2, -rows / 2, rows / 2, 1, 20);
  camera.lookAt([0, 0, 10], [0, 0, 0], [0, 1, 0]);
  await send("filament-lights.f32", await render(canvas.width, canvas.height));

  asset.getRenderableEntities().forEach(entity => scene.remove(entity));
  scene.setSkybox(engine.createSkyFromKtx1(sky));
  const seen = [];
  for (const [towards, up] of LOOKS) {
    camera.setProjectionFov(60, 1, 0.1, 100, Filament.Camera$Fov.VERTICAL);
    camera.lookAt([0, 0, 0], towards, up);
    seen.push(...(await render(16, 16)).subarray(4 * (16 * 8 + 8), 4 * (16 * 8 + 9)));
  }
  await send("filament-background.f32", new Float32Array(seen));
}
