// SPDX-License-Identifier: MIT OR Apache-2.0
// Spheres as triangles, and a layout of them as a file.

// A unit sphere of so many rings, with its poles along y: its points, which are its normals, and triangles.
export function sphere(rings) {
  const segments = 2 * rings;
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
  return { normals: new Float32Array(normals), indices: new Uint16Array(indices) };
}

// A binary glTF with one sphere a material.
export function spheres(layout, rings) {
  const { normals, indices } = sphere(rings);
  const parts = [normals.map(n => n * layout.radius), normals, indices];
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
