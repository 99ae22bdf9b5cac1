// SPDX-License-Identifier: MIT OR Apache-2.0
// Headless Chromium by its debugging pipe: pages, hands and screenshots.
import { spawn } from "node:child_process";
import { mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";

const LIMIT_MS = 120_000;

export async function launch(...flags) {
  const profile = mkdtempSync(join(tmpdir(), "view-"));
  const child = spawn(process.env.CHROMIUM ?? "chromium", [
    "--headless", "--no-sandbox", "--hide-scrollbars", "--disable-dev-shm-usage", "--force-device-scale-factor=1",
    "--remote-debugging-pipe", `--user-data-dir=${profile}`, ...flags,
  ], { stdio: ["ignore", "ignore", "pipe", "pipe", "pipe"] });
  const [, , stderr, input, output] = child.stdio;
  let log = "";
  stderr.on("data", text => { log += text; });

  const waiting = new Map();
  const listeners = [];
  let next = 1;
  let rest = Buffer.alloc(0);
  output.on("data", bytes => {
    rest = Buffer.concat([rest, bytes]);
    for (let end = rest.indexOf(0); end >= 0; end = rest.indexOf(0)) {
      const message = JSON.parse(rest.subarray(0, end));
      rest = rest.subarray(end + 1);
      if (message.id === undefined) listeners.forEach(listen => listen(message));
      else waiting.get(message.id)?.(message);
      waiting.delete(message.id);
    }
  });
  const ended = new Promise(resolve => { child.on("exit", resolve); });

  function send(method, params = {}, sessionId = undefined) {
    const id = next;
    next += 1;
    return new Promise((resolve, reject) => {
      const timer = setTimeout(() => reject(new Error(`${method}: no answer; ${log.slice(-2000)}`)), LIMIT_MS);
      waiting.set(id, message => {
        clearTimeout(timer);
        if (message.error) reject(new Error(`${method}: ${message.error.message}`));
        else resolve(message.result);
      });
      input.write(`${JSON.stringify({ id, method, params, sessionId })}\0`);
    });
  }

  /// A page, loaded, in a window of this size; `said` collects its console and what it throws.
  async function open(url, { width, height, scheme = "light", ratio = 1, touch = false }) {
    const { targetId } = await send("Target.createTarget", { url: "about:blank" });
    const { sessionId } = await send("Target.attachToTarget", { targetId, flatten: true });
    const to = (method, params) => send(method, params, sessionId);
    const said = [];
    const loaded = new Promise(resolve => {
      listeners.push(message => {
        if (message.sessionId !== sessionId) return;
        const { method, params } = message;
        if (method === "Page.loadEventFired") resolve();
        if (method === "Runtime.consoleAPICalled") said.push(`${params.type}: ${params.args.map(a => a.value ?? a.description).join(" ")}`);
        if (method === "Runtime.exceptionThrown") said.push(params.exceptionDetails.exception?.description ?? params.exceptionDetails.text);
        if (method === "Log.entryAdded") said.push(`${params.entry.level}: ${params.entry.text}`);
      });
    });
    await Promise.all(["Page", "Runtime", "Log"].map(domain => to(`${domain}.enable`)));
    const resize = (w, h) => to("Emulation.setDeviceMetricsOverride", { width: w, height: h, deviceScaleFactor: ratio, mobile: touch });
    await resize(width, height);
    await to("Emulation.setEmulatedMedia", { features: [{ name: "prefers-color-scheme", value: scheme }] });
    await to("Page.navigate", { url });
    await loaded;

    async function evaluate(expression) {
      const { result, exceptionDetails } = await to("Runtime.evaluate", { expression, awaitPromise: true, returnByValue: true });
      if (exceptionDetails) throw new Error(exceptionDetails.exception?.description ?? exceptionDetails.text);
      return result.value;
    }
    /// Until what was changed is on the screen.
    const settled = () => evaluate("new Promise(done => requestAnimationFrame(() => requestAnimationFrame(() => done(null))))");
    async function shot(clip = undefined) {
      await settled();
      const all = clip ? { clip: { ...clip, scale: 1 } } : { captureBeyondViewport: true };
      const { data } = await to("Page.captureScreenshot", { format: "png", ...all });
      return Buffer.from(data, "base64");
    }
    const mouse = (type, x, y, buttons) => to("Input.dispatchMouseEvent",
      { type, x, y, buttons, button: type === "mouseMoved" ? "none" : "left", clickCount: type === "mouseMoved" ? 0 : 1 });
    async function key(name, text = undefined) {
      await to("Input.dispatchKeyEvent", { type: "keyDown", key: name, text });
      await to("Input.dispatchKeyEvent", { type: "keyUp", key: name });
    }
    const close = () => send("Target.closeTarget", { targetId });
    return { said, evaluate, settled, shot, mouse, key, resize, close };
  }

  async function close() {
    await send("Browser.close");
    await ended;
    rmSync(profile, { recursive: true, force: true, maxRetries: 5, retryDelay: 200 });
  }
  return { open, close };
}
