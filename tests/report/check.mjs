// SPDX-License-Identifier: MIT OR Apache-2.0
// Bakes files of every kind that a page can show, sound ones and a wrong one, and looks at their pages in Chromium.
import { execFileSync, spawnSync } from "node:child_process";
import { readFileSync, writeFileSync } from "node:fs";
import { join, resolve } from "node:path";

const [baker, folder] = process.argv.slice(2).map(path => resolve(path));
const MOST_BYTES = 2e6;
const LEAST_NUMBERS = 10;

const problems = [];
function expect(page, holds, what) {
  if (!holds) problems.push(`${page}: ${what}`);
}

function bake(...words) {
  execFileSync(baker, [...words, "--quiet"], { cwd: folder });
}

// A user's hands: every button, the probe by pointer and by keys, the slider. A page's own scripts run before.
const HANDS = `<script>
for (const button of document.querySelectorAll("button")) button.click();
for (const canvas of document.querySelectorAll("canvas")) {
  const box = canvas.getBoundingClientRect();
  for (const [x, y] of [[0, 0], [0.4, 0.6], [1, 1]]) {
    const at = { clientX: box.left + x * box.width, clientY: box.top + y * box.height, bubbles: true };
    canvas.dispatchEvent(new PointerEvent("pointermove", at));
  }
  canvas.dispatchEvent(new KeyboardEvent("keydown", { key: "ArrowLeft", bubbles: true }));
}
for (const slider of document.querySelectorAll("input")) {
  slider.value = slider.max;
  slider.dispatchEvent(new Event("input"));
}
document.documentElement.setAttribute("data-exercised", "");
</script></body>`;

// Chromium with its console on stderr; what it writes to stdout, and the lines of the page's console.
function chromium(...words) {
  const always = ["--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars", "--enable-logging=stderr", "--v=0"];
  const ran = spawnSync(process.env.CHROMIUM ?? "chromium", [...always, ...words], { encoding: "utf8", maxBuffer: 1 << 28, timeout: 120_000 });
  if (ran.status !== 0) throw new Error(`chromium ${words.join(" ")}: ${ran.error ?? ran.stderr}`);
  return { dom: ran.stdout, console: ran.stderr.split("\n").filter(line => line.includes("CONSOLE")) };
}

// What a text of a page says, and how far it may be from the value: half of its last digit.
function says(text) {
  const number = text.replace(" %", "");
  const [mantissa, exponent = "0"] = number.split("e");
  const decimals = (mantissa.split(".")[1] ?? "").length;
  const percent = text.endsWith("%") ? 0.01 : 1;
  return { value: Number(number) * percent, half: 0.5 * 10 ** (Number(exponent) - decimals) * percent };
}

function check(file, right, ...more) {
  const page = `${file}.html`;
  const ran = spawnSync(baker, ["verify", file, "--json", "--report", page, ...more], { cwd: folder, encoding: "utf8" });
  expect(page, ran.status === (right ? 0 : 1), `verify ended with ${ran.status}: ${ran.stderr}`);
  const json = JSON.parse(ran.stdout);
  const text = readFileSync(join(folder, page), "utf8");
  expect(page, text.length < MOST_BYTES, `it has ${text.length} bytes`);

  // As it is, and after a user has tried everything.
  const exercised = `exercised-${page}`;
  writeFileSync(join(folder, exercised), text.replace("</body>", HANDS));
  for (const [name, hands] of [[page, false], [exercised, true]]) {
    const seen = chromium("--dump-dom", `file://${join(folder, name)}`);
    expect(name, seen.console.length === 0, `the console says: ${seen.console.join("; ")}`);
    expect(name, !seen.dom.includes('data-script-error=""'), "its script failed");
    expect(name, !hands || seen.dom.includes('data-exercised=""'), "the page could not be used");
    expect(name, seen.dom.includes(`id="verdict">${right ? "✓ right" : "✗ wrong"}<`), "the verdict is another one");

    const numbers = [...seen.dom.matchAll(/data-path="([^"]*)" data-value="([^"]*)">([^<]*)</g)];
    expect(name, numbers.length >= LEAST_NUMBERS, `only ${numbers.length} numbers`);
    for (const [, path, value, shown] of numbers) {
      const expected = path.split(".").reduce((at, key) => at[key], json);
      expect(name, value === JSON.stringify(expected), `${path} is ${value} on the page, ${expected} by --json`);
      const said = says(shown);
      expect(name, Math.abs(said.value - expected) <= said.half * (1 + 1e-9), `${path} reads ${shown}, but is ${expected}`);
    }
    const marks = (seen.dom.match(/class="mark /g) ?? []).length;
    expect(name, marks === json.report.laws.length, `${marks} laws of ${json.report.laws.length}`);
    if (!hands) console.log(`report: ${page}: ${numbers.length} numbers, ${marks} laws, ${text.length} bytes`);
  }
  for (const [scheme, setting] of [["dark", 0], ["light", 1]]) {
    chromium(`--blink-settings=preferredColorScheme=${setting}`, "--window-size=1200,3000",
      `--screenshot=${join(folder, `${file}.${scheme}.png`)}`, `file://${join(folder, page)}`);
  }
}

bake("bake", "split-sum", "-o", "dfg.ktx2");
check("dfg.ktx2", true);
bake("bake", "albedo", "-o", "albedo.exr", "--encoding", "r32f", "--size", "64x48", "--axes", "roughness,n_dot_v",
  "--points", "edges", "--flip-v");
check("albedo.exr", true);
bake("bake", "albedo", "-o", "copper.png", "--material", "copper", "--size", "32");
check("copper.png", true);
bake("bake", "average-albedo", "-o", "average.ktx2", "--size", "64");
check("average.ktx2", true);

// A level of rg16f is the last thing in its file: the first half of texel (7, 20), two steps up.
bake("bake", "split-sum", "-o", "changed.ktx2", "--size", "64");
const bytes = readFileSync(join(folder, "changed.ktx2"));
const place = bytes.length - 4 * (64 * 64 - (20 * 64 + 7));
bytes.writeUInt16LE(bytes.readUInt16LE(place) + 2, place);
writeFileSync(join(folder, "changed.ktx2"), bytes);
check("changed.ktx2", false);

bake("env", "sky.exr", "-o", "sky.ktx2", "--size", "64");
check("sky.ktx2", true, "--source", "sky.exr");
check("sky.ktx2", true);
bake("env", "sky.exr", "-o", "map.exr", "--shape", "octahedral", "--size", "64");
check("map.exr", true, "--source", "sky.exr");
bake("env", "sky.exr", "-o", "diffuse.hdr", "--kernel", "lambert", "--shape", "equirect", "--size", "32");
check("diffuse.hdr", true, "--source", "sky.exr");

problems.forEach(problem => console.error(`report: ${problem}`));
process.exit(problems.length === 0 ? 0 : 1);
