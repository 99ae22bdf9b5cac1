// SPDX-License-Identifier: MIT OR Apache-2.0
// Runs a page of this folder in headless Chromium on SwiftShader, and keeps what it sends.
//
// node browser.mjs PAGE.mjs FOLDER: the page imports engines from /npm/, reads FOLDER as /files/, and posts results into it
// with the functions of page.mjs. Warnings and errors of the page's console are failures.
import { spawn } from "node:child_process";
import { createServer } from "node:http";
import { readFileSync, rmSync, writeFileSync } from "node:fs";
import { basename, extname, join, normalize } from "node:path";

const [page, folder, modules, ...more] = process.argv.slice(2);
if (!modules || more.length > 0) {
  console.error("usage: browser.mjs PAGE.mjs FOLDER NODE_MODULES");
  process.exit(2);
}
// Seconds a page may take.
const LIMIT_MS = 1000 * (process.env.LIMIT ?? 240);
const roots = { npm: modules, files: folder, test: import.meta.dirname };
const types = { ".mjs": "text/javascript", ".js": "text/javascript", ".json": "application/json", ".wasm": "application/wasm" };

const html = `<!doctype html><meta charset="utf-8"><title>${page}</title><body>
<script type="importmap">{ "imports": {
  "three": "/npm/three/build/three.module.js", "three/addons/": "/npm/three/examples/jsm/",
  "playcanvas": "/npm/playcanvas/build/playcanvas.mjs" } }</script>
<script>
  const post = (path, body) => fetch(path, { method: "POST", body });
  const say = (level, words) => post("/say/" + level, words.map(String).join(" "));
  for (const level of ["warn", "error"]) {
    const print = console[level];
    console[level] = (...words) => { print(...words); say(level, words); };
  }
  addEventListener("error", event => say("error", [event.message, event.filename, event.lineno]));
  addEventListener("unhandledrejection", event => say("error", [event.reason?.stack ?? event.reason]));
</script>
<script type="module">
  import draw from "/test/${basename(page)}";
  try { await draw(); } catch (error) { say("error", [error.stack ?? error]); }
  post("/done", "");
</script>`;

const said = [];
let received = 0;
let finish;
const finished = new Promise(resolve => { finish = resolve; });

const server = createServer(async (request, response) => {
  const path = decodeURIComponent(new URL(request.url, "http://page").pathname);
  const answer = (status, type, body) => response.writeHead(status, { "content-type": type }).end(body);
  const [, root, ...rest] = path.split("/");
  if (request.method === "POST") {
    const parts = [];
    for await (const part of request) parts.push(part);
    const body = Buffer.concat(parts);
    if (root === "done") finish("done");
    else if (root === "say") {
      said.push(`${rest[0]}: ${body}`);
      // What waits for the thing that failed would wait for ever.
      if (rest[0] === "error") setTimeout(() => finish("ended by an error"), 5000);
    }
    else if (root === "send") {
      writeFileSync(join(folder, basename(rest.join("/"))), body);
      received += 1;
    }
    return answer(200, "text/plain", "");
  }
  if (path === "/") return answer(200, "text/html", html);
  if (path === "/favicon.ico") return answer(204, "text/plain", "");
  const inside = normalize(rest.join("/"));
  if (!(root in roots) || inside.startsWith("..")) return answer(404, "text/plain", "");
  try {
    answer(200, types[extname(inside)] ?? "application/octet-stream", readFileSync(join(roots[root], inside)));
  } catch {
    said.push(`error: the page asks for ${path}, which is not there`);
    answer(404, "text/plain", "");
  }
});
server.listen(0, "127.0.0.1", () => {
  // Its processes may still write when it has ended: the next run clears up.
  const profile = join(folder, `chromium-${basename(page, ".mjs")}`);
  rmSync(profile, { recursive: true, force: true, maxRetries: 5, retryDelay: 200 });
  const chromium = spawn(process.env.CHROMIUM ?? "chromium", [
    "--headless", "--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
    "--disable-dev-shm-usage", `--user-data-dir=${profile}`, `http://127.0.0.1:${server.address().port}/`,
  ], { stdio: ["ignore", "ignore", "pipe"] });
  let log = "";
  chromium.stderr.on("data", text => { log += text; });
  chromium.on("exit", code => finish(`Chromium ended with ${code}: ${log.slice(-2000)}`));
  const timer = setTimeout(() => finish(`nothing after ${LIMIT_MS / 1000} s`), LIMIT_MS);
  finished.then(how => {
    clearTimeout(timer);
    chromium.removeAllListeners("exit");
    chromium.on("exit", () => {
      const name = basename(page, ".mjs");
      said.forEach(line => console.error(`${name}: ${line}`));
      if (how !== "done") console.error(`${name}: ${how}`);
      if (received === 0) console.error(`${name}: the page sent nothing`);
      process.exit(how === "done" && said.length === 0 && received > 0 ? 0 : 1);
    });
    chromium.kill();
  });
});
