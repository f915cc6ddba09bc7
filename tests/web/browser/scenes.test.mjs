// Switching scenes, links to scenes that do not exist, saved pictures, the turntable, lights, tool tips and accessibility.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";

import axe from "axe-core";

import { near } from "../near.mjs";
import { Visit, distance, server, text, visit } from "./support.mjs";

const isVisible = (page, selector) => page.locator(selector).evaluate((e) => getComputedStyle(e).visibility === "visible");

visit("another scene hides the picture at once, and begins with a small one", {}, async (v, page) => {
  let release;
  const gate = new Promise((resolve) => { release = resolve; });
  await page.route("**/v1/scenes/teapots", async (route) => {
    await gate;
    await route.continue();
  });
  const before = v.frames.length;
  await page.selectOption("#scene", "teapots");
  assert.ok(!await isVisible(page, "#frame") && await isVisible(page, "#busy"));
  await page.focus("#stage");
  await page.keyboard.press("ArrowLeft");  // a movement of the old view
  await page.waitForTimeout(300);
  assert.equal(v.frames.length, before, "no frame of the old scene");
  release();
  await page.waitForFunction(() => !document.querySelector("#stage").classList.contains("busy"));
  const last = await v.settled();
  assert.ok(await isVisible(page, "#frame") && !await isVisible(page, "#busy"));
  const [small] = v.frames.slice(before);
  assert.deepEqual([small.scene, small.accuracy, last.scene], ["teapots", "draft", "teapots"]);
  near([small.width / last.width], [0.25], 0.01);
});

visit("another scene is requested at once, also while the page waits for a retry", {}, async (v, page) => {
  v.expected.push(/503/);
  await page.route("**/v1/frames*", (route) => (route.request().postDataJSON().scene === "six-walls"
    ? route.fulfill({ status: 503, headers: { "Retry-After": "500" }, contentType: "application/problem+json",
                      body: JSON.stringify({ title: "Render queue full", code: "queueFull", status: 503, detail: "Render queue is full; retry later." }) })
    : route.continue()));
  await page.click("[data-field=emission] input");
  await page.waitForFunction(() => document.querySelector("#countdown").textContent);
  await page.selectOption("#scene", "teapots");
  await page.waitForFunction(() => location.hash.includes("scene=teapots"));
  assert.equal((await v.settled()).scene, "teapots");
});

visit("a scene that cannot be loaded is named, and the one before is shown again", {}, async (v, page) => {
  await page.route("**/v1/scenes/teapots", (route) => route.fulfill({ json: { id: "teapots", state: "failed", failure: "the file is torn" } }));
  await page.selectOption("#scene", "teapots");
  await page.waitForSelector("#note.bad");
  assert.match(await text(page, "#note"), /could not be loaded.*the file is torn/s);
  assert.equal(await page.inputValue("#scene"), "six-walls");
  assert.ok(await isVisible(page, "#frame"));
});

test("a link to a missing scene says so and shows no other scene", { timeout: 600000 }, async () => {
  const v = await Visit.open(server.url, { path: "#scene=upload-gone" });
  v.expected.push(/404/);
  const { page } = v;
  await page.waitForSelector("#note.bad");
  assert.match(await text(page, "#note"), /There is no scene “upload-gone”.*Choose a scene/s);
  await page.waitForTimeout(500);
  assert.equal(v.frames.length, 0);
  await v.screenshot("missing-scene");
  const disabled = (ids) => page.evaluate((all) => all.map((id) => document.getElementById(id).disabled), ids);
  const buttons = ["copy-link", "copy-image-link", "copy-curl", "copy-json", "measure", "maps-show", "objects-list", "save"];
  assert.deepEqual(await disabled(buttons), buttons.map(() => true), "there is no view");
  await page.selectOption("#scene", "six-walls");
  assert.equal((await v.settled()).scene, "six-walls");
  assert.deepEqual(await disabled(buttons), buttons.map(() => false));
  await v.leave();
});

visit("the full frame is saved in each format, named by scene and size", {}, async (v, page) => {
  // Until its light is complete, the page requests the frame again now and then, also next to a file.
  await page.waitForFunction(() => !document.querySelector("#caption").textContent.includes("light"), undefined, { timeout: 590_000 });
  await v.settled();
  const marks = { png: [0x89, 0x50], jpeg: [0xff, 0xd8], webp: [0x52, 0x49] };
  const { width, height } = v.first;
  for (const [format, mark] of Object.entries(marks)) {
    await page.selectOption("#save-format", format);
    const [download] = await Promise.all([page.waitForEvent("download"), page.click("#save")]);
    assert.match(download.suggestedFilename(), new RegExp(`^.+ ${width}x${height}\\.${format === "jpeg" ? "jpg" : format}$`));
    const bytes = readFileSync(await download.path());
    assert.deepEqual([...bytes.subarray(0, 2)], mark);
    if (format === "png") assert.deepEqual([bytes.readUInt32BE(16), bytes.readUInt32BE(20)], [width, height]);
    await v.settled();  // the browser may report the end of the request after the file
  }
});

visit("the turntable turns about the target, pauses on input, and stops", {}, async (v, page) => {
  const start = v.first.camera;
  await page.click("#turntable");
  await page.waitForFunction((n) => n < performance.now(), await page.evaluate(() => performance.now() + 1200));
  await page.click("#turntable");
  const end = (await v.settled()).camera;
  near(end.target, start.target, 1e-6);
  near([distance(end.position, end.target)], [distance(start.position, start.target)], 1e-4);
  near([end.position[1]], [start.position[1]], 1e-4);
  assert.ok(distance(end.position, start.position) > 0.1);
  assert.equal(await page.getAttribute("#turntable", "aria-pressed"), "false");
});

visit("with reduced motion the turntable turns once by a fixed angle", { reducedMotion: "reduce" }, async (v, page) => {
  await page.click("#turntable");
  const { position: a, target } = v.first.camera, { position: b } = (await v.settled()).camera;
  const yaw = (p) => Math.atan2(p[0] - target[0], p[2] - target[2]);
  near([Math.cos(yaw(a) - yaw(b))], [Math.cos(Math.PI / 6)], 1e-4);
  assert.equal(await page.getAttribute("#turntable", "aria-pressed"), "false");
});

visit("lights have controls from the schema; changes are in requests and links, and can be taken back", { path: "#scene=chapel" }, async (v, page) => {
  const scene = await (await fetch(`${server.url}v1/scenes/chapel`)).json();
  const name = scene.lights.find((l) => l.name).name;
  const row = page.locator("#lights details", { has: page.locator(`summary b:text-is("${name}")`) });
  await row.locator("summary").click();
  await row.locator("[data-field=radius] input[type=number]").fill("0.2");
  await row.locator("[data-field=radius] input[type=number]").blur();
  assert.deepEqual((await v.settled()).lights, [{ light: name, radius: 0.2 }]);
  await row.locator("[data-field=enabled] input").uncheck({ force: true });
  const requested = await v.settled();
  assert.deepEqual(requested.lights, [{ light: name, radius: 0.2, enabled: false }]);
  await v.screenshot("lights");
  const other = await Visit.open(page.url());
  assert.deepEqual((await other.settled()).lights, requested.lights);
  await other.leave();
  await row.locator("text=Reset").click();
  assert.equal((await v.settled()).lights, undefined);
});

visit("lights and scenes can be added to the view, changed and removed", { path: "#scene=teapots" }, async (v, page) => {
  await v.settled();
  await page.selectOption("#add-light", "spot");
  const row = (list, name) => page.locator(`${list} details`, { has: page.locator(`summary b:text-is("${name}")`) });
  assert.equal((await v.settled()).lights.at(-1).type, "spot");
  await row("#lights", "light 1").locator("summary").click();
  await row("#lights", "light 1").locator("[data-field=color] input").nth(2).fill("0.1");
  await row("#lights", "light 1").locator("[data-field=color] input").nth(2).blur();
  const lit = await v.settled();
  assert.deepEqual(lit.lights.at(-1).color, [1, 1, 0.1]);
  await page.selectOption("#add-part", "orbiting-cubes");
  await page.waitForSelector("#parts details", { timeout: 60000 });
  const joined = await v.settled();
  assert.deepEqual(joined.scene.map(({ scene }) => scene), ["teapots", "orbiting-cubes"]);
  const { title } = await (await fetch(`${server.url}v1/scenes/orbiting-cubes`)).json();
  const part = row("#parts", title || "orbiting-cubes");
  await part.locator("summary").click();
  await part.locator("[data-field=translation] input").nth(1).fill("-1.2");
  await part.locator("[data-field=translation] input").nth(1).blur();
  const placed = await v.settled();
  assert.equal(placed.scene[1].translation[1], -1.2);
  await page.click("#objects-list");
  await page.waitForSelector("#objects details");
  const names = await page.locator("#objects summary b").allTextContents();
  assert.ok(names.includes("table") && names.some((name) => name.startsWith("orbiting-cubes/")), String(names));
  await v.screenshot("composition");
  const other = await Visit.open(page.url());
  const { scene, lights } = await other.settled();
  assert.deepEqual({ scene, lights }, { scene: placed.scene, lights: placed.lights }, "a link has them");
  await other.leave();
  await part.locator("text=Remove").click();
  assert.equal((await v.settled()).scene, "teapots");
  await row("#lights", "light 1").locator("text=Remove").click();
  assert.equal((await v.settled()).lights, undefined);
});

visit("objects in view can be listed, hidden and given another material; a colour can be the background", { path: "#scene=teapots" }, async (v, page) => {
  await v.settled();
  await page.click("#objects-list");
  const row = (name) => page.locator("#objects details", { has: page.locator(`summary b:text-is("${name}")`) });
  const name = "teapot copper";
  await row(name).locator("summary").click();
  const shares = await page.locator("#objects summary .quiet").allTextContents();
  assert.ok(shares.length > 2 && shares.every((share) => /^[\d.e-]+ %$/.test(share)), String(shares));
  await row(name).locator("[data-field=hidden] input").check({ force: true });
  assert.deepEqual((await v.settled()).nodes, [{ node: name, hidden: true }]);
  await page.click("#objects-list");
  await page.waitForFunction(() => document.querySelector("#objects summary .quiet")?.textContent === "");
  assert.equal(await row(name).count(), 1, "what is hidden stays in the list");
  await row("table").locator("summary").click();
  const { materials } = await (await fetch(`${server.url}v1/scenes/teapots`)).json();
  await row("table").locator("[data-field=material] select").selectOption(materials.at(-1));
  await page.locator("#background [data-field=background] select").selectOption("color");
  const requested = await v.settled();
  assert.deepEqual(requested.nodes, [{ node: name, hidden: true }, { node: "table", material: materials.at(-1) }]);
  assert.deepEqual(requested.background, [1, 1, 1]);
  await v.screenshot("objects");
  const other = await Visit.open(page.url());
  const { nodes, background } = await other.settled();
  assert.deepEqual({ nodes, background }, { nodes: requested.nodes, background: requested.background });
  await other.leave();
  await row(name).locator("summary").click();
  await row(name).locator("text=Reset").click();
  assert.deepEqual((await v.settled()).nodes, [{ node: "table", material: materials.at(-1) }]);
  await page.locator("#background [data-field=background] select").selectOption("map");
  assert.equal((await v.settled()).background, undefined);
});

visit("a ground has controls from the schema, and is in requests and links", { path: "#scene=teapots" }, async (v, page) => {
  await page.locator("#ground-switch input").check({ force: true });
  assert.equal((await v.settled()).ground.roughness, 1);
  await page.locator("#ground [data-field=roughness] input[type=number]").fill("0.1");
  await page.locator("#ground [data-field=roughness] input[type=number]").blur();
  const requested = await v.settled();
  assert.equal(requested.ground.roughness, 0.1);
  await v.screenshot("ground");
  const other = await Visit.open(page.url());
  assert.deepEqual((await other.settled()).ground, requested.ground);
  await other.leave();
  await page.locator("#ground-switch input").uncheck({ force: true });
  assert.equal((await v.settled()).ground, undefined);
});

visit("a slider without a value is in the middle and says none; every control has a tip, which the hint line shows", {}, async (v, page) => {
  await page.selectOption("#add-filter", "twirl");
  await v.settled();
  await page.click("#tab-accuracy");
  const sliders = await page.locator("input[type=range].unset").evaluateAll((all) => all.map((s) => [s.value / s.max, s.getAttribute("aria-valuetext")]));
  assert.ok(sliders.length > 0);
  for (const [at, words] of sliders) assert.deepEqual([Math.abs(at - 0.5) < 0.02, words], [true, "none"]);
  const slider = page.locator("[data-field=maxMilliseconds] input[type=range]");
  await slider.focus();
  await page.keyboard.press("ArrowRight");
  assert.ok((await v.settled()).accuracy.maxMilliseconds > 0);
  assert.ok(!await slider.evaluate((s) => s.classList.contains("unset")));
  assert.match(await text(page, "#hint"), /\w{3}.*\.$/);

  const without = await page.evaluate(() => [...document.querySelectorAll("button, input, select, summary, a[href], [role=tab]")]
    .filter((e) => !e.title && !e.closest("#rows, #decisions, #skipped, #notices details")).map((e) => e.outerHTML.slice(0, 120)));
  assert.deepEqual(without, []);
  await page.focus("#save");
  assert.equal(await text(page, "#hint"), await page.getAttribute("#save", "title"));
});

for (const [name, options] of [["desk", {}], ["phone, dark", { viewport: { width: 390, height: 844 }, isMobile: true, hasTouch: true, colorScheme: "dark" }]]) {
  visit(`axe finds no accessibility problem: ${name}`, { ...options, path: "#scene=chapel" }, async (v, page) => {
    await page.evaluate(axe.source);
    if (await page.isVisible("#help")) await page.click("#help");
    await page.locator("#lights summary").first().click();
    await page.selectOption("#add-filter", "twirl");
    await v.settled();
    for (const tab of ["view", "accuracy", "cost", "compare", "maps"]) {
      await page.click(`#tab-${tab}`);
      const { violations, passes } = await page.evaluate(() => window.axe.run(document, { resultTypes: ["violations"] }));
      assert.ok(passes.length > 20);
      assert.deepEqual(violations.map((r) => [r.id, r.nodes.map((n) => n.html.slice(0, 150))]), [], tab);
    }
  });
}
