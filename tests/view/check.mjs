// SPDX-License-Identifier: MIT OR Apache-2.0
// Opens a page of `brdf-baker view`, uses every control, and compares each screenshot with the picture that `brdf-baker
// preview` draws by the command on the page.
import { execFileSync } from "node:child_process";
import { readFileSync, writeFileSync } from "node:fs";
import { join, resolve } from "node:path";

import { launch } from "./browser.mjs";
import { decode } from "./png.mjs";

const [baker, folder] = process.argv.slice(2).map(path => resolve(path));
/// Root mean square of the differences over the pixels inside of a sphere, in steps of 8 bits: of all spheres, of any one.
const MOST_RMS = 0.1;
const MOST_SPHERE = 0.2;
/// The same of what is behind them.
const MOST_BACKGROUND = 0.1;
/// What a control changes at least.
const LEAST_CHANGE = 0.5;
const RADIUS = 11 / 24;

const problems = [];
function expect(holds, what) {
  if (!holds) problems.push(what);
}
const run = (...words) => execFileSync(baker, [...words, "--quiet"], { cwd: folder });

/// The sphere that a whole pixel shows; -1 behind them, null on a rim.
function sphereAt(x, y, { width, height }, [columns, rows]) {
  const tile = Math.min(width / columns, height / rows);
  const place = [(x + 0.5 - width / 2) / tile + columns / 2, (y + 0.5 - height / 2) / tile + rows / 2];
  const [column, row] = place.map(Math.floor);
  const reach = Math.hypot(place[0] - column - 0.5, place[1] - row - 0.5) - RADIUS;
  const inside = column >= 0 && row >= 0 && column < columns && row < rows;
  if (inside && reach < -1 / tile) return row * columns + column;
  return inside && reach < 1 / tile ? null : -1;
}

/// Root mean square of the differences: over all spheres, of the worst one, and behind them.
function difference(a, b, grid) {
  if (a.width !== b.width || a.height !== b.height) throw new Error(`${a.width}x${a.height} and ${b.width}x${b.height}`);
  const sums = new Map();
  for (let y = 0; y < a.height; y += 1) {
    for (let x = 0; x < a.width; x += 1) {
      const sphere = sphereAt(x, y, a, grid);
      if (sphere === null) continue;
      const sum = sums.get(sphere) ?? [0, 0];
      for (let c = 0; c < 3; c += 1) {
        const i = 3 * (y * a.width + x) + c;
        sum[0] += (a.rgb[i] - b.rgb[i]) ** 2;
        sum[1] += 1;
      }
      sums.set(sphere, sum);
    }
  }
  const root = ([squares, count]) => Math.sqrt(squares / count);
  const spheres = [...sums].filter(([sphere]) => sphere >= 0).map(([, sum]) => sum);
  if (spheres.length !== grid[0] * grid[1]) throw new Error(`${spheres.length} spheres were compared`);
  const all = spheres.reduce(([a, b], [c, d]) => [a + c, b + d]);
  return { rms: root(all), worst: Math.max(...spheres.map(root)), behind: root(sums.get(-1)) };
}

/// What a user does to a control.
const choose = (id, value) => `{ const e = document.getElementById("${id}"); e.value = "${value}"; e.dispatchEvent(new Event("change")); }`;
const slide = (id, value) => `{ const e = document.getElementById("${id}"); e.value = "${value}"; e.dispatchEvent(new Event("input")); }`;
const click = id => `document.getElementById("${id}").click();`;

run("env", "sky.exr", "-o", "sky.ktx2", "--size", "128", "--irradiance", "diffuse.ktx2");
run("env", "evening.exr", "-o", "evening.ktx2", "--size", "64", "--roughness-law", "quadratic", "--file-axes", "-z,y,x");
run("bake", "split-sum", "-o", "dfg.ktx2", "--size", "64", "--channels", "scale,bias,f82");
run("bake", "split-sum", "-o", "beckmann.exr", "--size", "48x32", "--ndf", "beckmann", "--channels", "bias,albedo",
  "--axes", "roughness,sqrt_n_dot_v", "--flip-v", "--points", "edges");
// Without a word of what it holds.
run("bake", "split-sum", "-o", "plain.dds", "--size", "64", "--visibility", "schlick-ggx", "--flip-v");
const files = ["sky.ktx2", "evening.ktx2", "diffuse.ktx2", "dfg.ktx2", "beckmann.exr", "plain.dds"];
const made = JSON.parse(run("view", ...files, "-o", "view.html", "--json"));
expect(made.environments === 3 && made.irradiance_maps === 1 && made.tables === 3, `the page holds ${JSON.stringify(made)}`);
const url = `file://${join(folder, "view.html")}`;

// Nothing given: the built-in sky, and a table that is baked.
const own = JSON.parse(run("view", "-o", "own.html", "--json"));
expect(own.environments === 2 && own.tables === 1, `the page of nothing holds ${JSON.stringify(own)}`);

const gpu = ["--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"];
const browser = await launch(...gpu);
let page = await browser.open(url, { width: 1000, height: 640 });

async function screenshot() {
  await page.settled();
  const box = await page.evaluate(`{ const { x, y, width, height } = document.getElementById("spheres").getBoundingClientRect();
    ({ x: x + scrollX, y: y + scrollY, width, height }) }`);
  expect(Object.values(box).every(Number.isInteger), `the picture is not at whole pixels: ${JSON.stringify(box)}`);
  return page.shot(box);
}

let last = null;
let figures = [];
/// After `act` the picture is another one, and that of the command on the page.
async function compare(name, act, grid = [5, 5]) {
  if (typeof act === "string") await page.evaluate(`{ ${act} } null`);
  else await act();
  const file = await screenshot();
  const seen = decode(file);
  const words = await page.evaluate(`document.getElementById("command").textContent`);
  execFileSync("sh", ["-c", `"$BAKER" ${words.replace(/^brdf-baker /, "")} --quiet`], { cwd: folder, env: { ...process.env, BAKER: baker } });
  const drawn = readFileSync(join(folder, "spheres.png"));
  writeFileSync(join(folder, `${name}.page.png`), file);
  writeFileSync(join(folder, `${name}.preview.png`), drawn);
  const found = difference(seen, decode(drawn), grid);
  expect(found.rms <= MOST_RMS && found.worst <= MOST_SPHERE && found.behind <= MOST_BACKGROUND,
    `${name}: ${JSON.stringify(found)} from the picture of ${words}`);
  if (last) {
    let squares = 0;
    for (let i = 0; i < seen.rgb.length; i += 1) squares += (seen.rgb[i] - last.rgb[i]) ** 2;
    const change = Math.sqrt(squares / seen.rgb.length);
    expect(change >= LEAST_CHANGE, `${name}: the picture has changed by ${change} only`);
  }
  last = seen;
  figures.push({ name, ...found });
  console.log(`view: ${name}: rms ${found.rms.toFixed(3)}, worst sphere ${found.worst.toFixed(3)}, behind ${found.behind.toFixed(3)} of 255`);
}

await compare("first", "");
await compare("rotate", slide("rotate", 90));
await compare("tilt", slide("tilt", -30));
await compare("compensate", click("compensate"));
await compare("colour", slide("colour", "#b04a2f"));
await compare("metal", choose("material", "iron"));
await compare("dielectric", choose("material", "diamond"));
await compare("exposure", slide("ev", 1.25));
await compare("tone", choose("tone", "clip"));
await compare("background", choose("background", "grey"));
await compare("light", choose("light", "1") + choose("background", "env"));
await compare("table", choose("table", "1"));
await compare("table-of-others", choose("table", "2"));
await compare("reset", click("reset"));
await compare("diffuse", choose("diffuse", "") + slide("colour", "#ffffff"));
await compare("white-room", choose("light", "2"));
await compare("one", choose("light", "0") + choose("layout", "one") + slide("metallic", 0.8) + slide("roughness", 0.25), [1, 1]);

// By pointer and by keys.
await page.evaluate(`${click("reset")} null`);
const box = await page.evaluate(`{ const b = document.getElementById("spheres").getBoundingClientRect(); ({ x: b.x, y: b.y, width: b.width, height: b.height }) }`);
const [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
await page.mouse("mouseMoved", x, y, 0);
expect((await page.evaluate(`document.getElementById("probe").textContent`)) === "Here: metallic 0.50, roughness 0.50.", "the probe names another sphere");
await page.mouse("mousePressed", x, y, 1);
await page.mouse("mouseMoved", x + 120, y + 40, 1);
await page.mouse("mouseReleased", x + 120, y + 40, 0);
const degrees = 1.1547 / box.height * 180 / Math.PI;
const turned = await page.evaluate("({ rotate: state.rotate, tilt: state.tilt })");
expect(Math.abs(turned.rotate + 120 * degrees) <= 0.26 && Math.abs(turned.tilt - 40 * degrees) <= 0.26, `a drag turns by ${JSON.stringify(turned)}`);
await compare("drag", "");
await page.evaluate(`document.getElementById("spheres").focus(); null`);
await page.key("ArrowLeft");
await page.key("ArrowDown");
await page.key("+", "+");
const keyed = await page.evaluate("({ rotate: state.rotate - " + turned.rotate + ", tilt: state.tilt - " + turned.tilt + ", ev: state.ev })");
expect(keyed.rotate === 5 && keyed.tilt === -5 && keyed.ev === 0.5, `keys change ${JSON.stringify(keyed)}`);
await page.key("Home");
expect(await page.evaluate("state.rotate === 0 && state.tilt === 0"), "Home does not look ahead");
// A metal's edge needs a table of it.
await page.evaluate(`${choose("material", "iron")} ${choose("table", "1")} null`);
expect((await page.evaluate(`document.getElementById("warning").textContent`)).includes("no f82"), "a missing tint is not said");
await page.evaluate(`${click("reset")} null`);
const before = decode(await screenshot());
// Nine harmonics are nearly the irradiance.
await page.evaluate(`${choose("diffuse", "harmonics")} null`);
const nearly = difference(decode(await screenshot()), before, [5, 5]);
expect(nearly.rms > 0.1 && nearly.rms < 5 && nearly.worst < 8 && nearly.behind === 0, `harmonics: ${JSON.stringify(nearly)}`);
await page.evaluate(`${choose("light", "2")} null`);
expect(await page.evaluate(`document.querySelector("#diffuse [value=harmonics]").disabled`), "the white room states no harmonics");
// A GPU that goes and comes back.
await page.evaluate(`${click("reset")} null`);
await page.evaluate(`{ const gl = document.getElementById("spheres").getContext("webgl2").getExtension("WEBGL_lose_context");
  gl.loseContext(); new Promise(done => setTimeout(() => { gl.restoreContext(); setTimeout(() => done(null), 300); }, 100)) }`);
const after = decode(await screenshot());
expect(difference(before, after, [5, 5]).rms === 0, "the picture does not come back with the GPU");
expect(page.said.filter(line => !/context (lost|restored)/i.test(line)).length === 0, `the console says: ${page.said.join("; ")}`);
await page.close();
page = await browser.open(`file://${join(folder, "own.html")}`, { width: 1000, height: 640 });
last = null;
await compare("built-in", "");
await compare("built-in-metal", choose("material", "copper") + click("compensate"));
expect(page.said.length === 0, `the console says: ${page.said.join("; ")}`);
await page.close();

// What a user sees, wide and narrow, light and dark.
for (const [name, options] of Object.entries({
  light: { width: 1280, height: 800 },
  dark: { width: 1280, height: 800, scheme: "dark" },
  narrow: { width: 390, height: 844, scheme: "dark", ratio: 2, touch: true },
})) {
  const look = await browser.open(url, options);
  writeFileSync(join(folder, `${name}.png`), await look.shot());
  const wide = await look.evaluate("document.documentElement.scrollWidth - document.documentElement.clientWidth");
  expect(wide <= 0, `${name}: the page is ${wide} pixels wider than the window`);
  const unnamed = await look.evaluate(`[...document.querySelectorAll("input, select")].filter(e => !e.labels.length).map(e => e.id)`);
  expect(unnamed.length === 0, `${name}: without a label: ${unnamed}`);
  expect(look.said.length === 0, `${name}: the console says: ${look.said.join("; ")}`);
  await look.close();
}
await browser.close();

// Without WebGL 2 a message, and nothing else goes wrong.
const without = await launch("--disable-gpu", "--disable-3d-apis");
const plain = await without.open(url, { width: 1000, height: 640 });
writeFileSync(join(folder, "without.png"), await plain.shot());
const message = await plain.evaluate(`document.getElementById("no-webgl")?.textContent ?? ""`);
expect(/WebGL 2/.test(message) && /brdf-baker preview -o/.test(message), `without WebGL 2 it says: ${message}`);
expect((await plain.evaluate(`document.querySelectorAll("canvas, [data-script-error]").length`)) === 0, "without WebGL 2 there is a canvas");
expect(plain.said.length === 0, `without WebGL 2 the console says: ${plain.said.join("; ")}`);
await without.close();

const most = key => Math.max(...figures.map(f => f[key])).toFixed(3);
console.log(`view: ${figures.length} pictures, ${made.bytes} bytes; at most rms ${most("rms")}, worst sphere ${most("worst")}, behind ${most("behind")} of 255`);
problems.forEach(problem => console.error(`view: ${problem}`));
process.exit(problems.length === 0 ? 0 : 1);
