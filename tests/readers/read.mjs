// Reads the KTX2 sample files with ktx-parse and compares them with values.json.
import { readFileSync } from "node:fs";
import { join } from "node:path";
import { read } from "ktx-parse";

const folder = process.argv[2];
const VK_FORMATS = { r16f: 76, rg16f: 83, rgba16f: 97, r32f: 100, rg32f: 103, rgba32f: 109 };

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

let compared = 0;
for (const entry of JSON.parse(readFileSync(join(folder, "values.json"), "utf8"))) {
  if (!entry.file.endsWith(".ktx2")) continue;
  const file = read(new Uint8Array(readFileSync(join(folder, entry.file))));
  const size = entry.encoding.includes("16f") ? 2 : 4;

  // Header and descriptor.
  expect(entry, "vkFormat", file.vkFormat, VK_FORMATS[entry.encoding]);
  expect(entry, "typeSize", file.typeSize, size);
  expect(entry, "size", [file.pixelWidth, file.pixelHeight, file.pixelDepth], [entry.levels[0].width, entry.levels[0].height, 0]);
  expect(entry, "layers and faces", [file.layerCount, file.faceCount], [0, entry.faces]);
  expect(entry, "supercompression", file.supercompressionScheme, 0);
  expect(entry, "levels", file.levels.length, entry.levels.length);
  const [descriptor, ...more] = file.dataFormatDescriptor;
  expect(entry, "further descriptors", more.length, 0);
  expect(entry, "model, primaries, transfer", [descriptor.colorModel, descriptor.colorPrimaries, descriptor.transferFunction], [1, 1, 1]);
  expect(entry, "bytesPlane", descriptor.bytesPlane[0], size * entry.components);
  expect(entry, "samples", descriptor.samples.map((s) => [s.bitOffset, s.bitLength + 1]),
    Array.from({ length: entry.components }, (_, i) => [i * size * 8, size * 8]));

  // Metadata.
  const text = (key) => {
    const value = file.keyValue[key];
    return typeof value === "string" ? value.replace(/\0$/, "") : value && new TextDecoder().decode(value).replace(/\0$/, "");
  };
  for (const [key, value] of Object.entries({ ...entry.meta, channels: entry.channels.join(",") })) {
    expect(entry, key, text(`brdf-baker.${key}`), value);
  }
  expect(entry, "KTXorientation", text("KTXorientation"), entry.faces === 6 ? undefined : "rd");

  // Values. Components beyond the channels hold 0, a fourth one 1.
  entry.levels.forEach((level, i) => {
    const data = file.levels[i].levelData;
    const view = new DataView(data.buffer, data.byteOffset, data.byteLength);
    expect(entry, `bytes of level ${i}`, data.byteLength, level.width * level.height * entry.faces * entry.components * size);
    for (const probe of level.probes) {
      const texel = (probe.face * level.height + probe.y) * level.width + probe.x;
      const found = Array.from({ length: entry.components }, (_, c) => {
        const at = (texel * entry.components + c) * size;
        return size === 2 ? half(view.getUint16(at, true)) : view.getFloat32(at, true);
      });
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
console.log(`readers: ktx-parse ${compared} texels equal`);
