// SPDX-License-Identifier: MIT OR Apache-2.0
// Prints what ktx-parse finds in a KTX2 file, its levels as base64, so that a program in another language need not parse it.
import { readFileSync } from "node:fs";
import { read } from "ktx-parse";

const file = read(new Uint8Array(readFileSync(process.argv[2])));
console.log(JSON.stringify({
  vkFormat: file.vkFormat,
  width: file.pixelWidth,
  height: file.pixelHeight,
  faces: file.faceCount,
  layers: file.layerCount,
  levels: file.levels.map((level) => Buffer.from(level.levelData).toString("base64")),
}));
