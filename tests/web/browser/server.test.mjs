// The page with a server that is loading, busy, restarting or protected, or rejects a request.
import assert from "node:assert/strict";
import { mkdtempSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { test } from "node:test";

import { freePort, serve } from "../server_process.mjs";
import { Visit, server, text, visit } from "./support.mjs";

visit("an outdated full frame is aborted", {}, async (v, page) => {
  let aborted = 0;
  page.on("requestfailed", (request) => { aborted += request.url().includes("explain=1"); });
  await page.route("**/v1/frames?explain=1", async (route) => {
    await new Promise((resolve) => setTimeout(resolve, 800));
    await route.continue().catch(() => {});
  });
  await page.focus("#stage");
  await page.keyboard.press("ArrowLeft");
  await page.waitForRequest((r) => r.url().includes("explain=1"));
  await page.keyboard.press("ArrowLeft");
  await v.settled();
  assert.equal(aborted, 1);
});

visit("a busy server is reported and the request is retried", {}, async (v, page) => {
  v.expected.push(/503/);
  let refusals = 0;
  await page.route("**/v1/frames*", (route) => (refusals++ < 1
    ? route.fulfill({ status: 503, headers: { "Retry-After": "2" }, contentType: "application/problem+json",
                      body: JSON.stringify({ title: "Render queue full", code: "queueFull", status: 503, detail: "Render queue is full; retry later." }) })
    : route.continue()));
  await page.click("[data-field=emission] input");
  await page.waitForSelector("#note:not([hidden])");
  assert.match(await text(page, "#note"), /The server is busy.*Render queue is full.*Retrying in [12] s/s);
  await v.screenshot("busy");
  await page.click("[data-field=refraction] input");  // is not sent meanwhile
  assert.equal((await v.settled()).effects.refraction, false);
  assert.equal(refusals, 2);
});

visit("a frame that exceeds the deadline is retried with fewer pixels", {}, async (v, page) => {
  v.expected.push(/504/);
  const full = v.frames[0].width * v.frames[0].height;
  await page.route("**/v1/frames*", (route) => {
    const { width, height } = route.request().postDataJSON();
    return width * height > 0.3 * full
      ? route.fulfill({ status: 504, contentType: "application/problem+json",
                        body: JSON.stringify({ title: "Deadline exceeded", code: "overDeadline", status: 504, detail: "The frame was not rendered within 10 s." }) })
      : route.continue();
  });
  await page.click("[data-field=emission] input");
  const last = await v.settled();
  assert.ok(last.width * last.height > 0.2 * full && last.width * last.height < 0.3 * full);
  await page.unroute("**/v1/frames*");
  await page.click("[data-field=emission] input");
  assert.equal((await v.settled()).width, v.frames[0].width);
});

visit("an invalid request shows the field and the allowed values", {}, async (v, page) => {
  v.expected.push(/422/);
  await page.evaluate(() => { document.querySelector("[data-field=map] select").append(new Option("nowhere", "nowhere")); });
  await page.selectOption("[data-field=map] select", "nowhere");
  await page.waitForSelector("#note.bad");
  assert.match(await text(page, "#note"), /request is invalid.*\/environment\/map there is no such environment map.*one of: /s);
});

test("the page continues after a restart of the server", { timeout: 120000 }, async () => {
  const port = await freePort();
  const first = await serve({ port });
  const v = await Visit.open(first.url);
  v.expected.push(/Failed to load resource|ERR_/);
  await v.settled();
  await first.stop();
  await v.page.click("[data-field=emission] input");
  await v.page.waitForSelector("#note.bad");
  assert.match(await text(v.page, "#note"), /does not respond.*restarting.*Retrying/s);
  const second = await serve({ port });
  assert.equal((await v.settled()).effects.emission, false);
  await v.leave();
  await second.stop();
});

test("a required token is sent with every request", { timeout: 120000 }, async () => {
  const file = join(mkdtempSync(join(tmpdir(), "clerestory-")), "token");
  writeFileSync(file, "open-sesame-to-the-chapel\n", { mode: 0o600 });
  const guarded = await serve({ more: ["--token-file", file] });
  const v = await Visit.open(guarded.url);
  v.expected.push(/401/);
  const { page } = v;
  await page.waitForSelector("#token-form:not([hidden])");
  assert.equal(v.frames.length, 0);
  await page.fill("#token", "wrong");
  await page.keyboard.press("Enter");
  await page.waitForFunction(() => document.activeElement.id === "token" && document.querySelector("#token").value === "");
  await page.fill("#token", "open-sesame-to-the-chapel");
  await page.keyboard.press("Enter");
  await v.settled();
  await page.reload();
  await v.settled();
  assert.ok(!await page.isVisible("#token-form"));
  await v.leave();
  await guarded.stop();
});

visit("loading progress is shown; without animations there is no time slider; without uploads no upload button",
      {}, async (v, page) => {
  let polls = 0;
  await page.route("**/v1/scenes/teapots", async (route) => (polls++ < 2
    ? route.fulfill({ json: { id: "teapots", state: "loading", stage: "cutting clusters", progress: 0.4 } }) : route.continue()));
  await page.selectOption("#scene", "teapots");
  await page.waitForFunction(() => document.querySelector("#note progress:not([hidden])")?.value === 0.4);
  assert.match(await text(page, "#note"), /Loading teapots.*cutting clusters/s);
  await page.waitForFunction(() => location.hash.includes("scene=teapots"));
  assert.equal((await v.settled()).scene, "teapots");
  assert.ok(!await page.isVisible("#time-row"));
  assert.ok(!await page.isVisible("#upload-pick"));
});

visit("the time of an animated scene can be played", { path: "#scene=orbiting-cubes" }, async (v, page) => {
  await page.click("#play");
  await page.waitForFunction(() => Number(document.querySelector("#time").value) > 0.2);
  await page.click("#play");
  const { time } = await v.settled();
  assert.ok(time > 0.2);
  const [first, last] = [v.frames[0], v.frames.at(-1)];
  assert.equal(first.scene, "orbiting-cubes");
  assert.ok(last.time > 0.2 && v.frames.filter((f) => f.time > 0).length > 1);
});

// One triangle.
function glb() {
  const binary = Buffer.from(new Float32Array([0, 0, 0, 1, 0, 0, 0, 1, 0]).buffer);
  const json = JSON.stringify({
    asset: { version: "2.0" }, scene: 0, scenes: [{ nodes: [0] }], nodes: [{ mesh: 0 }],
    meshes: [{ primitives: [{ attributes: { POSITION: 0 } }] }], buffers: [{ byteLength: 36 }],
    bufferViews: [{ buffer: 0, byteLength: 36 }],
    accessors: [{ bufferView: 0, componentType: 5126, type: "VEC3", count: 3, min: [0, 0, 0], max: [1, 1, 0] }],
  });
  const text = Buffer.from(json.padEnd(Math.ceil(json.length / 4) * 4));
  const numbers = (...list) => Buffer.from(new Uint32Array(list).buffer);
  return Buffer.concat([Buffer.from("glTF"), numbers(2, 12 + 8 + text.length + 8 + 36, text.length), Buffer.from("JSON"), text,
                        numbers(36), Buffer.from("BIN\0"), binary]);
}

test("an uploaded file becomes a scene; an invalid file is reported and changes nothing", { timeout: 120000 }, async () => {
  const folder = mkdtempSync(join(tmpdir(), "clerestory-uploads-"));
  const open = await serve({ more: ["--uploads", folder, "--max-upload", "100000"] });
  const v = await Visit.open(open.url);
  v.expected.push(/415|422/);
  const { page } = v;
  await v.settled();
  const send = (name, buffer) => page.setInputFiles("#upload", { name, mimeType: "model/gltf-binary", buffer });
  const posted = page.waitForRequest((r) => r.method() === "POST" && r.url().includes("/v1/scenes"));
  await send("My triangle.glb", glb());
  assert.equal((await posted).headers()["content-type"], "model/gltf-binary");
  await page.waitForFunction(() => location.hash.includes("scene=upload-"));
  const id = (await v.settled()).scene;
  assert.match(id, /^upload-[0-9a-f]{32}$/);
  assert.equal(await page.locator("#scene option:checked").textContent(), "My triangle.glb");
  await v.screenshot("upload");

  const refusal = async (name, buffer, words) => {
    await send(name, buffer);
    await page.waitForFunction((w) => new RegExp(w).test(document.querySelector("#note.bad")?.textContent ?? ""), words.source);
    await page.waitForFunction((stays) => document.querySelector("#scene").value === stays, id);
  };
  // A failed scene is no longer in the list when a slow response arrives.
  await page.route(/\/v1\/scenes$/, (route) => setTimeout(() => route.continue(), 500));
  await refusal("torn.glb", glb().subarray(0, 100), /not as long as its header/);
  await refusal("hollow.zip", Buffer.from("PK\x03\x04 and no more"), /could not be loaded|archive/);
  await refusal("words.glb", Buffer.from("words"), /Unsupported media type/);
  await refusal("huge.glb", Buffer.alloc(100001), /the limit of the server is 98 KB/);
  await v.leave();
  await open.stop();
});

test("the Content-Security-Policy is strict", async () => {
  const policy = (await fetch(server.url)).headers.get("Content-Security-Policy");
  assert.match(policy, /default-src 'self'/);
  assert.doesNotMatch(policy, /unsafe/);
});
