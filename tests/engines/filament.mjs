// SPDX-License-Identifier: MIT OR Apache-2.0
// Filament (WebAssembly): six lights in KTX files of brdf-baker, on spheres of a glTF file and behind them.
import { spheres } from "./glb.mjs";
import { LOOKS, json, script, send, url } from "./page.mjs";

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
  // A glTF file: there is no other way to a lit material without the engine's compiler.
  const asset = loader.createAsset(spheres(layout, 64));
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
