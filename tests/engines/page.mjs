// SPDX-License-Identifier: MIT OR Apache-2.0
// What pages share: reading the test's files, sending pictures.

export const url = name => `/files/${name}`;

export async function json(name) {
  return (await fetch(url(name))).json();
}

export async function bytes(name) {
  const answer = await fetch(url(name));
  if (!answer.ok) throw new Error(`${name}: ${answer.status}`);
  return answer.arrayBuffer();
}

export async function send(name, floats) {
  await fetch(`/send/${name}`, { method: "POST", body: floats });
}

// Rows from the top of a picture whose rows start at the bottom, four values a pixel.
export function fromTheTop(floats, width) {
  const turned = new Float32Array(floats.length);
  const row = 4 * width;
  for (let at = 0; at < floats.length; at += row) turned.set(floats.subarray(at, at + row), floats.length - row - at);
  return turned;
}

// The six directions of a background test: where the camera looks, and what is up.
export const LOOKS = [
  [[1, 0, 0], [0, 1, 0]], [[-1, 0, 0], [0, 1, 0]], [[0, 1, 0], [0, 0, 1]],
  [[0, -1, 0], [0, 0, -1]], [[0, 0, 1], [0, 1, 0]], [[0, 0, -1], [0, 1, 0]],
];

// A script that is no module, once it has run.
export function script(address) {
  return new Promise((resolve, reject) => {
    const element = document.createElement("script");
    element.onload = resolve;
    element.onerror = () => reject(new Error(`${address} does not load`));
    element.src = address;
    document.head.append(element);
  });
}
