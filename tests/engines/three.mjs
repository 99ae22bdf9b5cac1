// SPDX-License-Identifier: MIT OR Apache-2.0
// three.js: the spheres with maps of brdf-baker, and with those that PMREMGenerator makes.
import * as THREE from "three";
import { EXRLoader } from "three/addons/loaders/EXRLoader.js";
import { KTX2Loader } from "three/addons/loaders/KTX2Loader.js";
import { fromTheTop, json, LOOKS, send, url } from "./page.mjs";

// The loader hands out an uncompressed cube as a flat texture whose mips hold six faces each: make it a cube.
function pmrem(flat) {
  const face = i => ({
    width: flat.image.width,
    height: flat.image.height,
    mipmaps: flat.mipmaps.map(({ data, width, height }) => {
      const length = data.length / 6;
      return { data: data.subarray(i * length, (i + 1) * length), width, height };
    }),
  });
  const cube = new THREE.CompressedCubeTexture([0, 1, 2, 3, 4, 5].map(face), flat.format, flat.type);
  cube.minFilter = THREE.LinearMipmapLinearFilter;
  cube.magFilter = THREE.LinearFilter;
  cube.colorSpace = THREE.LinearSRGBColorSpace;
  cube.isPMREMTexture = true;
  cube.needsUpdate = true;
  return cube;
}

// three.js sets its own table before every draw, whatever the material holds: let the uniform keep ours.
function withTable(material, table) {
  material.onBeforeCompile = shader => {
    Object.defineProperty(shader.uniforms.dfgLUT, "value", { get: () => table, set() {} });
  };
}

export default async function draw() {
  const renderer = new THREE.WebGLRenderer();
  const loader = new KTX2Loader().detectSupport(renderer);
  const table = await loader.loadAsync(url("three-dfg.ktx2"));
  table.minFilter = table.magFilter = THREE.LinearFilter;
  table.needsUpdate = true;

  function spheres(layout, environment, lut) {
    const scene = new THREE.Scene();
    scene.environment = environment;
    const shape = new THREE.SphereGeometry(layout.radius, 256, 128);
    for (const { centre, colour, metallic, roughness } of layout.spheres) {
      const material = new THREE.MeshStandardMaterial({ metalness: metallic, roughness });
      material.color.setRGB(...colour, THREE.LinearSRGBColorSpace);
      if (lut) withTable(material, lut);
      const mesh = new THREE.Mesh(shape, material);
      mesh.position.set(...centre, 0);
      scene.add(mesh);
    }
    return scene;
  }

  function render(scene, camera, width, height) {
    const target = new THREE.WebGLRenderTarget(width, height, { type: THREE.FloatType, colorSpace: THREE.LinearSRGBColorSpace });
    const pixels = new Float32Array(4 * width * height);
    renderer.setRenderTarget(target);
    renderer.render(scene, camera);
    renderer.readRenderTargetPixels(target, 0, 0, width, height, pixels);
    target.dispose();
    return pixels;
  }

  async function picture(name, layout, environment, lut) {
    const [columns, rows] = layout.tiles, [width, height] = layout.size_px;
    const camera = new THREE.OrthographicCamera(-columns / 2, columns / 2, rows / 2, -rows / 2, 1, 20);
    camera.position.z = 10;
    await send(name, fromTheTop(render(spheres(layout, environment, lut), camera, width, height), width));
  }

  const layout = await json("spheres.json");
  const sky = pmrem(await loader.loadAsync(url("three-sky.ktx2")));
  const equirect = await new EXRLoader().setDataType(THREE.FloatType).loadAsync(url("sky.exr"));
  equirect.mapping = THREE.EquirectangularReflectionMapping;
  await picture("three-ours.f32", layout, sky, table);
  await picture("three-table.f32", layout, sky);
  await picture("three-own.f32", layout, equirect);

  const lights = pmrem(await loader.loadAsync(url("three-lights.ktx2")));
  await picture("three-lights.f32", await json("lights.json"), lights, table);

  // What lies behind the scene, in each direction.
  const scene = new THREE.Scene();
  scene.background = lights;
  const seen = LOOKS.flatMap(([towards, up]) => {
    const camera = new THREE.PerspectiveCamera(60, 1, 0.1, 100);
    camera.up.set(...up);
    camera.lookAt(...towards);
    return [...render(scene, camera, 8, 8).subarray(4 * (8 * 4 + 4), 4 * (8 * 4 + 5))];
  });
  await send("three-background.f32", new Float32Array(seen));
}
