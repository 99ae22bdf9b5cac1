// SPDX-License-Identifier: MIT OR Apache-2.0
// Reads the KTX2 sample files with ktx-parse and compares them with values.json: header, descriptor, metadata, and the
// values of floats and integers. (read.py has the values of the others.)
import { readFileSync } from "node:fs";
import { join } from "node:path";
import { read } from "ktx-parse";

const folder = process.argv[2];
// VkFormat, typeSize, color model, bytes and side of a texel or block, bits of the samples.
const word = (...bits) => [4, 1, 4, 1, bits];
const block = (model, bytes, ...bits) => [1, model, bytes, 4, bits];
const plain = (size, n) => [size, 1, size * n, 1, Array(n).fill(8 * size)];
const FORMATS = {
  r16f: [76, ...plain(2, 1)], rg16f: [83, ...plain(2, 2)], rgba16f: [97, ...plain(2, 4)],
  r32f: [100, ...plain(4, 1)], rg32f: [103, ...plain(4, 2)], rgba32f: [109, ...plain(4, 4)],
  r8unorm: [9, ...plain(1, 1)], rg8unorm: [16, ...plain(1, 2)], rgba8unorm: [37, ...plain(1, 4)],
  r16unorm: [70, ...plain(2, 1)], rg16unorm: [77, ...plain(2, 2)], rgba16unorm: [91, ...plain(2, 4)],
  a2b10g10r10: [64, ...word(10, 10, 10, 2)], b10g11r11: [122, ...word(11, 11, 10)],
  rgb9e5: [123, ...word(9, 5, 9, 5, 9, 5)],
  rgbd8: [37, ...plain(1, 4)], rgbm8: [37, ...plain(1, 4)], rgbp8: [37, ...plain(1, 4)],
  bc4: [139, ...block(131, 8, 64)], bc5: [141, ...block(132, 16, 64, 64)], bc6h: [143, ...block(133, 16, 128)],
};

function fail(entry, what) {
  console.error(`ktx-parse: ${entry.file}: ${what}`);
  process.exit(1);
}

function expect(entry, what, found, expected) {
  if (JSON.stringify(found) !== JSON.stringify(expected)) {
    fail(entry, `${what} is ${JSON.stringify(found)}, expected ${JSON.stringify(expected)}`);
  }
}

function half(bits) {
  const sign = bits >> 15 ? -1 : 1;
  const exponent = (bits >> 10) & 31;
  const mantissa = bits & 1023;
  if (exponent === 31) return NaN;
  return sign * (exponent === 0 ? mantissa * 2 ** -24 : (1 + mantissa / 1024) * 2 ** (exponent - 15));
}

// How a component is read, where each is stored by itself.
function reader(encoding) {
  const kind = encoding.replace(/^(rgba|rgb|rg|r)/, "");
  return {
    "16f": (view, at) => half(view.getUint16(at, true)),
    "32f": (view, at) => view.getFloat32(at, true),
    "8unorm": (view, at) => Math.fround(view.getUint8(at) / 255),
    "16unorm": (view, at) => Math.fround(view.getUint16(at, true) / 65535),
  }[kind];
}

let files = 0;
let compared = 0;
for (const entry of JSON.parse(readFileSync(join(folder, "values.json"), "utf8"))) {
  if (!entry.file.endsWith(".ktx2")) continue;
  const file = read(new Uint8Array(readFileSync(join(folder, entry.file))));
  const [vkFormat, typeSize, colorModel, bytes, side, bits] = FORMATS[entry.encoding];
  const isPacked = entry.compression === "zstd";
  files += 1;

  // Header and descriptor.
  expect(entry, "vkFormat", file.vkFormat, vkFormat);
  expect(entry, "typeSize", file.typeSize, typeSize);
  expect(entry, "size", [file.pixelWidth, file.pixelHeight, file.pixelDepth], [entry.levels[0].width, entry.levels[0].height, 0]);
  expect(entry, "layers and faces", [file.layerCount, file.faceCount], entry.layers ? [entry.layers, 1] : [0, entry.faces]);
  expect(entry, "supercompression", file.supercompressionScheme, isPacked ? 2 : 0);
  expect(entry, "levels", file.levels.length, entry.levels.length);
  const [descriptor, ...more] = file.dataFormatDescriptor;
  expect(entry, "further descriptors", more.length, 0);
  expect(entry, "model, primaries, transfer", [descriptor.colorModel, descriptor.colorPrimaries, descriptor.transferFunction], [colorModel, 1, 1]);
  expect(entry, "bytesPlane", descriptor.bytesPlane[0], isPacked ? 0 : bytes);
  expect(entry, "block", [...descriptor.texelBlockDimension].slice(0, 2), [side - 1, side - 1]);
  expect(entry, "samples", descriptor.samples.map((s) => s.bitLength + 1), bits);

  // Metadata.
  const text = (key) => {
    const value = file.keyValue[key];
    return typeof value === "string" ? value.replace(/\0$/, "") : value && new TextDecoder().decode(value).replace(/\0$/, "");
  };
  const meta = { ...entry.meta, channels: entry.channels.join(",") };
  if (entry.decode) Object.assign(meta, { encoding: entry.encoding, "encoding.decode": entry.decode });
  for (const [key, value] of Object.entries(meta)) {
    expect(entry, key, text(`brdf-baker.${key}`), value);
  }
  expect(entry, "KTXorientation", text("KTXorientation"), entry.faces === 6 ? undefined : "rd");

  // Sizes, and values where levels are plain. Components beyond the channels hold 0, a fourth one 1.
  const component = reader(entry.encoding);
  entry.levels.forEach((level, i) => {
    const { levelData: data, uncompressedByteLength } = file.levels[i];
    const blocks = Math.ceil(level.width / side) * Math.ceil(level.height / side) * entry.faces;
    expect(entry, `bytes of level ${i}`, uncompressedByteLength, blocks * bytes);
    if (isPacked || !component) return;
    const view = new DataView(data.buffer, data.byteOffset, data.byteLength);
    const size = bytes / entry.components;
    for (const probe of level.probes) {
      const texel = (probe.face * level.height + probe.y) * level.width + probe.x;
      const found = Array.from({ length: entry.components }, (_, c) => component(view, (texel * entry.components + c) * size));
      const padding = [0, 0, 0, 1].slice(probe.values.length, entry.components);
      const expected = [...probe.values.map(Math.fround), ...padding];
      expect(entry, `level ${i} at ${probe.face}, ${probe.x}, ${probe.y}`, found, expected);
      compared += 1;
    }
  });
}
if (compared === 0) {
  console.error("ktx-parse: compared nothing");
  process.exit(1);
}
console.log(`readers: ktx-parse ${files} files, ${compared} texels equal`);
