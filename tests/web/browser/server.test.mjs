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
  const sent = [];  // times of requests, milliseconds
  await page.route("**/v1/frames*", (route) => (sent.push(performance.now()) === 1
    ? route.fulfill({ status: 503, headers: { "Retry-After": "2" }, contentType: "application/problem+json",
                      body: JSON.stringify({ title: "Render queue full", code: "queueFull", status: 503, detail: "Render queue is full; retry later." }) })
    : route.continue()));
  // [id, text] of the parts of the status, as they are written.
  await page.evaluate(() => {
    window.written = [];
    new MutationObserver((all) => window.written.push(...all.map(({ target }) => [target.id, target.textContent])))
      .observe(document.querySelector("#note"), { childList: true, subtree: true });
  });
  await page.click("[data-field=emission] input");
  await page.waitForSelector("#note:not([hidden])");
  assert.match(await text(page, "#note"), /The server is busy.*Render queue is full.*Retrying in [12] s/s);
  await v.screenshot("busy");
  await page.click("[data-field=refraction] input");
  assert.equal((await v.settled()).effects.refraction, false);
  assert.ok(sent[1] - sent[0] > 1900, "nothing is sent before the time of Retry-After");
  const written = (wanted) => page.evaluate((id) => window.written.filter(([of, words]) => of === id && words).map(([, words]) => words), wanted);
  assert.deepEqual(await written("countdown"), [" in 2 s.", " in 1 s."]);
  assert.equal(await page.getAttribute("#countdown", "aria-hidden"), "true");
  assert.deepEqual((await written("note-text")).map((words) => /Retrying$/.test(words)), [true], "screen readers announce the retry once");
});

visit("a frame that exceeds the deadline is retried with fewer pixels", {}, async (v, page) => {
  v.expected.push(/504/);
  const full = v.first.width * v.first.height;
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
  assert.equal((await v.settled()).width, v.first.width);
});

visit("an invalid request shows the field and the allowed values", {}, async (v, page) => {
  v.expected.push(/422/);
  await page.evaluate(() => { document.querySelector("[data-field=map] select").append(new Option("nowhere", "nowhere")); });
  await page.selectOption("[data-field=map] select", "nowhere");
  await page.waitForSelector("#note.bad");
  assert.match(await text(page, "#note"), /request is invalid.*\/environment\/map there is no such environment map.*one of: /s);
});

test("the page continues after a restart of the server", { timeout: 600000 }, async () => {
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

test("a required token is sent with every request", { timeout: 600000 }, async () => {
  const file = join(mkdtempSync(join(tmpdir(), "clerestory-")), "token");
  writeFileSync(file, "open-sesame-to-the-chapel\n", { mode: 0o600 });
  const guarded = await serve({ more: ["--token-file", file] });
  const v = await Visit.open(guarded.url);
  v.expected.push(/401/);
  const { page } = v;
  await page.waitForSelector("#token-form:not([hidden])");
  assert.ok(!await page.isVisible("#token-form [role=alert]"), "no token was sent");
  assert.equal(v.frames.length, 0);
  await page.fill("#token", "wrong");
  await page.keyboard.press("Enter");
  await page.waitForFunction(() => document.activeElement.id === "token" && document.querySelector("#token").value === "");
  assert.equal(await text(page, "#token-form [role=alert]"), "The server rejected this token.");
  await v.screenshot("token-rejected");
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
  assert.match(await text(page, "#note"), /Loading Teapots.*cutting clusters/s);
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

test("the Content-Security-Policy is strict", async () => {
  const policy = (await fetch(server.url)).headers.get("Content-Security-Policy");
  assert.match(policy, /default-src 'self'/);
  assert.doesNotMatch(policy, /unsafe/);
});
