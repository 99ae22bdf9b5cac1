// SPDX-License-Identifier: MIT OR Apache-2.0
// PNG files of 8 bits, RGB or RGBA, as bytes of RGB.
import { inflateSync } from "node:zlib";

const SIGNATURE = Buffer.from([0x89, 0x50, 0x4e, 0x47, 0x0d, 0x0a, 0x1a, 0x0a]);

export function decode(file) {
  if (!file.subarray(0, 8).equals(SIGNATURE)) throw new Error("it is no PNG");
  const parts = [];
  let [width, height, channels] = [0, 0, 0];
  for (let at = 8; at < file.length;) {
    const [length, name] = [file.readUInt32BE(at), file.toString("latin1", at + 4, at + 8)];
    const body = file.subarray(at + 8, at + 8 + length);
    if (name === "IHDR") {
      [width, height] = [body.readUInt32BE(0), body.readUInt32BE(4)];
      channels = { 2: 3, 6: 4 }[body[9]];
      if (body[8] !== 8 || channels === undefined || body[12] !== 0) throw new Error("it is no plain RGB of 8 bits");
    }
    if (name === "IDAT") parts.push(body);
    at += 12 + length;
  }
  const lines = inflateSync(Buffer.concat(parts));
  const row = width * channels;
  const texels = Buffer.alloc(row * height);
  const predicted = (filter, left, up, corner) => {
    if (filter === 1) return left;
    if (filter === 2) return up;
    if (filter === 3) return (left + up) >> 1;
    if (filter !== 4) return 0;
    const p = left + up - corner;
    const [a, b, c] = [left, up, corner].map(v => Math.abs(p - v));
    return a <= b && a <= c ? left : b <= c ? up : corner;
  };
  for (let y = 0; y < height; y += 1) {
    const filter = lines[y * (row + 1)];
    for (let i = 0; i < row; i += 1) {
      const at = y * row + i;
      const left = i >= channels ? texels[at - channels] : 0;
      const up = y > 0 ? texels[at - row] : 0;
      const corner = i >= channels && y > 0 ? texels[at - row - channels] : 0;
      texels[at] = lines[y * (row + 1) + 1 + i] + predicted(filter, left, up, corner);
    }
  }
  const rgb = Buffer.alloc(3 * width * height);
  for (let i = 0; i < width * height; i += 1) texels.copy(rgb, 3 * i, i * channels, i * channels + 3);
  return { width, height, rgb };
}
