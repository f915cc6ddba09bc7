// User interaction in a real browser with a real server.
import assert from "node:assert/strict";
import { test } from "node:test";

import { near } from "../near.mjs";
import { patiently } from "../server_process.mjs";
import { Visit, distance, same, server, text, visit } from "./support.mjs";

visit("the first frame is shown with its costs and decisions", {}, async (v, page) => {
  assert.equal(v.frames.length, 2);
  const [small] = v.frames;
  assert.ok(small.accuracy === "draft" && small.width <= 0.26 * v.first.width, "a small one, then the full one");
  assert.match(await text(page, "#caption"), /\d+ × \d+ · .* ms/);
  await page.click("#tab-cost");
  assert.ok(await page.locator("#rows > li").count() >= 3);
  assert.match(await text(page, "#decisions"), /Ball/);
  await page.locator("#decisions summary").first().click();
  assert.match(await text(page, "#decisions table"), /error \d/);
  const bars = await page.locator("#rows .full").evaluateAll((all) => all.map((r) => r.getBoundingClientRect().width));
  assert.ok(Math.max(...bars) > 200 && bars.some((width) => width < 100), `${bars}`);
  const picture = await page.locator("#frame").evaluate((i) => [i.naturalWidth, i.naturalHeight]);
  assert.deepEqual(picture, [v.first.width, v.first.height]);
});

visit("while dragging, one small frame at a time with the newest pose, then the full one", {}, async (v, page) => {
  const full = v.first;
  await page.route("**/v1/frames*", async (route) => {
    await new Promise((resolve) => setTimeout(resolve, 120));
    await route.continue();
  });
  const box = await page.locator("#stage").boundingBox();
  await page.mouse.move(box.x + 300, box.y + 300);
  await page.mouse.down();
  for (let i = 1; i <= 60; ++i) await page.mouse.move(box.x + 300 + 3 * i, box.y + 300);
  await page.mouse.up();
  const last = await v.settled();
  assert.ok(v.frames.length < 40, `${v.frames.length} frames for 60 movements`);
  assert.ok(v.frames.some((f) => f.width * f.height < 0.5 * full.width * full.height), "small ones while moving");
  assert.deepEqual([last.width, last.height], [full.width, full.height]);
  // The rotation about the target for 180 pixels.
  const turned = (180 / Math.min(box.width, box.height)) * Math.PI;
  const yaw = ({ position: p, target: t }) => Math.atan2(p[0] - t[0], p[2] - t[2]);
  const difference = Math.abs(yaw(full.camera) - yaw(last.camera));
  near([Math.min(difference, 2 * Math.PI - difference)], [turned], 1e-3);
  near([distance(last.camera.position, last.camera.target)], [distance(full.camera.position, full.camera.target)], 1e-3);
});

visit("the wheel zooms in and out, and a drag with shift pans", {}, async (v, page) => {
  const start = v.frames.at(-1).camera, away = ({ position, target }) => distance(position, target);
  const box = await page.locator("#stage").boundingBox();
  await page.mouse.move(box.x + 300, box.y + 300);
  await page.mouse.wheel(0, -300);
  const nearer = (await v.settled()).camera;
  assert.ok(away(nearer) < 0.95 * away(start), "nearer");
  near(nearer.target, start.target, 1e-6);
  await page.mouse.wheel(0, 300);
  near([away((await v.settled()).camera)], [away(start)], 1e-6);

  await page.keyboard.down("Shift");
  await page.mouse.down();
  await page.mouse.move(box.x + 400, box.y + 300, { steps: 5 });
  await page.mouse.up();
  await page.keyboard.up("Shift");
  const panned = (await v.settled()).camera, way = distance(panned.target, start.target);
  assert.ok(way > 0.05 * away(start), "moved");
  near([distance(panned.position, start.position), away(panned)], [way, away(start)], 1e-4);
});

visit("the environment map can be changed, rotated and hidden", {}, async (v, page) => {
  const before = v.frames.at(-1);
  const maps = await page.locator("#light select option").evaluateAll((all) => all.map((o) => o.value).filter(Boolean));
  const other = maps.find((name) => name !== before.environment?.map);
  await page.selectOption("#light select", other);
  assert.equal((await v.settled()).environment.map, other);
  const heading = page.getByLabel("Heading").last();
  await heading.fill("90");
  await heading.press("Enter");
  const half = Math.SQRT1_2;
  near((await v.settled()).environment.rotation.map(Math.abs), [0, half, 0, half], 1e-6);
  await page.getByLabel("Visible").first().focus();
  await page.keyboard.press("Space");
  assert.equal((await v.settled()).environment.visible, false);
});

const kLater = 600_000;  // milliseconds of the clock of the test

// Presses keys at times of a clock that the test controls, with a given frame rate.
async function flown(rate, keys) {
  const v = await Visit.open(server.url, { before: async (page) => {
    await page.clock.install({ time: 0 });
    await page.addInitScript((hertz) => {
      window.requestAnimationFrame = (draw) => setTimeout(() => draw(performance.now()), 1000 / hertz);
    }, rate);
  } });
  const { page } = v;
  const start = (await v.settled()).camera;
  await page.focus("#stage");
  await page.clock.pauseAt(kLater);
  for (const [act, key, milliseconds] of keys) {
    await page.keyboard[act](key);
    await page.clock.runFor(milliseconds);
  }
  await page.clock.runFor(4000);
  await page.clock.resume();
  await v.settled();
  const end = v.frames.at(-1).camera;
  await v.leave();
  return { start, end, way: distance(start.position, end.position) };
}

test("the same keys fly the same path at 30 and at 144 frames a second", { timeout: 600000 }, async () => {
  const keys = [["down", "w", 300], ["down", "d", 250], ["up", "w", 200], ["up", "d", 0]];
  const slow = await flown(30, keys), fast = await flown(144, keys);
  assert.ok(slow.way > 0.2, `${slow.way}`);
  same(slow.end, fast.end);
});

test("diagonals are not faster than straight flight", { timeout: 600000 }, async () => {
  const ahead = await flown(60, [["down", "w", 400], ["up", "w", 0]]);
  const diagonal = await flown(60, [["down", "w", 0], ["down", "d", 400], ["up", "w", 0], ["up", "d", 0]]);
  assert.ok(ahead.way > 0.2);
  near([diagonal.way], [ahead.way], 2e-3);
});

visit("the page shows the progress of the light between surfaces until it is complete", {}, async (v, page) => {
  const answers = [];
  page.on("response", async (response) => {
    const light = response.headers()["clerestory-light"];
    if (light) answers.push(light);
  });
  await page.uncheck("#effects [data-field=indirectLight] input", { force: true });
  await v.settled();
  await page.check("#effects [data-field=indirectLight] input", { force: true });
  while (!answers.some((light) => light.includes("share=1.00"))) await page.waitForTimeout(100);
  await page.waitForFunction(() => !document.querySelector("#caption").textContent.includes("light"));
  assert.ok(v.frames.at(-1).effects.indirectLight);
});

visit("the keyboard reaches the image, rotation, panning, zoom, effects and tabs", {}, async (v, page) => {
  const start = v.frames.at(-1);
  const focused = () => page.evaluate(() => document.activeElement.id);
  for (let i = 0; i < 8 && await focused() !== "stage"; ++i) await page.keyboard.press("Tab");
  assert.equal(await focused(), "stage");
  for (const [key, changes] of [["ArrowLeft", "position"], ["Shift+ArrowUp", "target"], ["+", "position"]]) {
    const before = (await v.settled()).camera;
    await page.keyboard.press(key);
    assert.ok(distance((await v.settled()).camera[changes], before[changes]) > 1e-3, key);
  }
  for (const key of ["r", "R"]) {  // R: with Caps Lock
    await page.keyboard.press("ArrowLeft");
    assert.ok(distance((await v.settled()).camera.position, start.camera.position) > 1e-3);
    await page.keyboard.press(key);
    await page.waitForTimeout(400);
    same((await v.settled()).camera, start.camera);
  }
  for (let i = 0; i < 12 && await focused() !== "tab-view"; ++i) await page.keyboard.press("Tab");
  await page.keyboard.press("ArrowRight");
  assert.equal(await focused(), "tab-accuracy");
  assert.ok(await page.isVisible("#panel-accuracy") && !await page.isVisible("#panel-view"));
  await page.keyboard.press("Tab");
  await page.keyboard.press("ArrowRight");  // the preset after standard
  assert.equal((await v.settled()).accuracy.preset, "fine");
  await page.click("#tab-view");
  await page.focus("#effects input");
  await page.keyboard.press("Space");
  assert.equal((await v.settled()).effects.emission, false);
});

visit("every control has an accessible name", {}, async (v, page) => {
  await page.check("input[value=fly]", { force: true });
  await page.click("#help");
  if (await page.isVisible("#add-filter")) {
    for (const { value } of await page.locator("#add-filter option").evaluateAll((all) => all.map((o) => ({ value: o.value })))) {
      if (value) await page.selectOption("#add-filter", value);
    }
    await v.settled();
  }
  const nameless = await page.evaluate(() => [...document.querySelectorAll("button, input, select, [role]:not(option), a[href]")]
    .filter((e) => {
      const named = e.getAttribute("aria-label") || e.labels?.length && [...e.labels].some((l) => l.textContent.trim()) ||
        document.getElementById(e.getAttribute("aria-labelledby"))?.textContent.trim() || e.textContent.trim();
      return !named && !["status", "alert", "presentation"].includes(e.getAttribute("role"));
    }).map((e) => e.outerHTML.slice(0, 120)));
  assert.deepEqual(nameless, []);
  const ids = await page.evaluate(() => [...document.querySelectorAll("[id]")].map((e) => e.id));
  assert.equal(new Set(ids).size, ids.length, "an id is not unique");
});

visit("a double click sets the orbit centre", {}, async (v, page) => {
  const before = v.frames.at(-1).camera;
  await page.dblclick("#stage");
  await page.waitForTimeout(500);
  const { position, target } = (await v.settled()).camera;
  near([Math.hypot(...target)], [0.5], 0.01);  // the ball of six-walls
  near([distance(position, before.position) + distance(position, target)], [distance(before.position, target)], 1e-3);
  assert.ok(distance(position, target) < 0.7 * distance(before.position, target));
});

visit("a link restores view and settings; so do curl and JSON", {}, async (v, page) => {
  await page.focus("#stage");
  await page.keyboard.press("ArrowLeft");
  await page.click("[data-field=planarReflection] input");
  await page.fill("[data-field=exposure] input[type=number]", "-0.5");
  await page.locator("[data-field=exposure] input[type=number]").blur();
  await page.click("#tab-accuracy");
  await page.fill("[data-field=generations] input[type=number]", "3");
  await page.locator("[data-field=generations] input[type=number]").blur();
  await page.click("#tab-view");
  const requested = await v.settled();
  assert.deepEqual([requested.exposure, requested.accuracy.generations, requested.effects.planarReflection], [-0.5, 3, false]);
  const copied = async (id) => {
    await page.click(id);
    await page.waitForFunction(() => document.querySelector("#copied").textContent.startsWith("Copied"));
    return page.evaluate(() => navigator.clipboard.readText());
  };
  assert.deepEqual(JSON.parse(await copied("#copy-json")), requested);
  const curl = await copied("#copy-curl");
  assert.deepEqual(JSON.parse(/-d '(.*)' -o/s.exec(curl)[1]), requested);
  const picture = await (await patiently(await copied("#copy-image-link"))).arrayBuffer();
  const posted = await (await patiently(`${server.url}v1/frames`, {
    method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify(requested) })).arrayBuffer();
  assert.deepEqual(Buffer.from(picture), Buffer.from(posted));
  const other = await Visit.open(await copied("#copy-link"));
  const again = await other.settled();
  same(again.camera, requested.camera);
  assert.deepEqual({ ...again, camera: 0 }, { ...requested, camera: 0 });
  await other.leave();
});

visit("filters can be added, moved and removed, and a link contains them", {}, async (v, page) => {
  await page.selectOption("#add-filter", "twirl");
  await page.selectOption("#add-filter", "convolve");
  assert.deepEqual((await v.settled()).filters, [{ type: "twirl", amount: 1 }, { type: "convolve", kernel: "sharpen" }]);
  await page.fill("#filters [data-field=amount] input[type=number]", "2.5");
  await page.locator("#filters [data-field=amount] input[type=number]").blur();
  await page.click("#filters li:nth-child(2) [aria-label=Earlier]");
  const requested = await v.settled();
  assert.deepEqual(requested.filters, [{ type: "convolve", kernel: "sharpen" }, { type: "twirl", amount: 2.5 }]);
  const other = await Visit.open(page.url());
  assert.deepEqual((await other.settled()).filters, requested.filters);
  await other.leave();
  await page.click("#filters [aria-label=Remove]");
  assert.deepEqual((await v.settled()).filters, [{ type: "twirl", amount: 2.5 }]);
});

visit("the view can be shared as a live view", {}, async (v, page) => {
  const put = page.waitForRequest((r) => r.method() === "PUT");
  await page.click("#live");
  assert.deepEqual((await put).postDataJSON(), await v.settled());
  const place = new URL(await page.getAttribute("#live-link", "href"));
  const view = await (await fetch(`${server.url}v1/views/${place.searchParams.get("view")}`)).json();
  assert.deepEqual(view.camera, v.frames.at(-1).camera);
});

visit("with reduced motion nothing is animated, and every frame is a full one", { reducedMotion: "reduce" }, async (v, page) => {
  const full = v.first;
  await page.dblclick("#stage");
  await v.settled();
  await page.focus("#stage");
  await page.keyboard.press("w", { delay: 120 });
  const { length } = v.frames;
  await v.settled();
  assert.ok(v.frames.slice(1).every((f) => f.width === full.width && f.accuracy.preset), "full ones only");
  assert.ok(v.frames.length - length <= 3, "it stops with the key");
  assert.equal(await page.evaluate(() => getComputedStyle(document.querySelector("button")).transitionDuration), "0s");
});

visit("touch rotates and pinches; the arrow buttons fly", { hasTouch: true, isMobile: true, viewport: { width: 390, height: 844 } }, async (v, page) => {
  const touch = await page.context().newCDPSession(page);
  const send = (type, ...points) => touch.send("Input.dispatchTouchEvent", { type, touchPoints: points.map(([x, y], id) => ({ x, y, id })) });
  const start = v.first.camera;
  const box = await page.locator("#stage").boundingBox();
  const [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
  await send("touchStart", [x, y]);
  for (let i = 1; i <= 5; ++i) await send("touchMove", [x + 10 * i, y]);
  await send("touchEnd");
  const turned = (await v.settled()).camera;
  near(turned.target, start.target, 1e-6);
  assert.ok(distance(turned.position, start.position) > 0.1);
  await send("touchStart", [x - 30, y], [x + 30, y]);
  for (let i = 1; i <= 5; ++i) await send("touchMove", [x - 30 - 6 * i, y], [x + 30 + 6 * i, y]);
  await send("touchEnd");
  const pinched = (await v.settled()).camera;
  near([distance(pinched.position, pinched.target) / distance(turned.position, turned.target)], [0.5], 0.01);
  await page.check("input[value=fly]", { force: true });
  await page.locator("[data-code=KeyE]").click({ delay: 200 });
  assert.ok((await v.settled()).camera.position[1] > pinched.position[1] + 0.01);
  const wide = await page.evaluate(() => [document.scrollingElement.scrollWidth, innerWidth]);
  assert.ok(wide[0] <= wide[1], `the page is ${wide[0]} wide on ${wide[1]}`);
});

visit("two settings are compared, and the line moves by key", {}, async (v, page) => {
  await page.click("#tab-compare");
  await page.click("#wipe-start");
  await page.waitForSelector("#wipe", { state: "visible" });
  await v.settled();
  assert.ok(Object.values(v.frames.at(-1).effects).every((on) => on === false));
  const edge = () => page.locator("#wipe-line").evaluate((e) => e.getBoundingClientRect().left);
  const before = await edge();
  await page.focus("#wipe");
  for (let i = 0; i < 20; ++i) await page.keyboard.press("ArrowRight");
  assert.ok(await edge() > before + 50);
  await page.selectOption("#wipe-with", "preset:draft");
  assert.equal((await v.settled()).accuracy, "draft");
  await page.click("#wipe-start");
  await v.settled();
  assert.ok(!await page.isVisible("#after"));
});

// Selects points of the chart by keyboard while their images are late or missing; at the end the second one is selected.
async function pointsByKeyboard(v, page) {
  v.expected.push(/404/);
  const focused = () => page.evaluate(() => [...document.querySelectorAll("#chart circle")].indexOf(document.activeElement));
  const select = async (i, key) => {
    await page.locator("#chart circle").nth(i).focus();
    await page.keyboard.press(key);
    assert.equal(await focused(), i, "the point keeps the focus");
    assert.equal(await page.locator("#chart circle.chosen").count(), 1);
    assert.ok(await page.locator("#chart circle").nth(i).evaluate((e) => e.classList.contains("chosen")), key);
  };
  const isImage = (url) => /\/v1\/jobs\/[^/]+\/./.test(url.pathname);
  const words = await text(page, "#measure-words");
  const pixel = Buffer.from("iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mNk+M9QDwADhgGAWjR9awAAAABJRU5ErkJggg==", "base64");
  let release;
  const late = new Promise((resolve) => { release = resolve; });
  const answers = [  // to the requests for images, in their order
    async (route) => {
      await late;
      await route.fulfill({ contentType: "image/png", body: pixel });
    },
    (route) => route.continue(),
    (route) => route.fulfill({ status: 404, contentType: "application/problem+json",
                               body: JSON.stringify({ title: "Not found", status: 404, detail: "There is no such job." }) }),
  ];
  await page.route(isImage, (route) => (answers.shift() ?? ((other) => other.continue()))(route));

  await select(0, " ");
  await select(1, "Enter");
  await page.waitForSelector("#error-image", { state: "visible" });
  const arrived = page.waitForEvent("requestfinished", (request) => isImage(new URL(request.url())));
  release();
  await arrived;
  await page.waitForTimeout(200);
  assert.equal(await page.locator("#error-image").evaluate((i) => i.naturalWidth), 160, "an image that is out of date is ignored");

  await select(2, " ");
  await page.waitForFunction(() => document.querySelector("#measure-words").textContent.includes("There is no such job."));
  assert.ok(!await page.isVisible("#error-image"));
  await select(1, " ");
  await page.waitForSelector("#error-image", { state: "visible" });
  assert.equal(await text(page, "#measure-words"), words);
  await page.click("#chart-details button >> text=Hide");
  assert.deepEqual([await focused(), await page.isVisible("#error-image")], [1, false]);
  await page.keyboard.press("Enter");
  await page.waitForSelector("#error-image", { state: "visible" });
}

visit("a measurement shows a chart, error images, and the reference in the comparison", {}, async (v, page) => {
  await page.click("#tab-compare");
  await page.selectOption("#reference-samples", "4");
  await page.selectOption("#reference-width", "160");
  await page.click("#measure");
  await page.waitForSelector("#chart circle");
  assert.equal(await page.locator("#chart circle").count(), 3);
  assert.ok((await page.locator("#chart .hull").getAttribute("points")).trim().length > 0);
  await page.locator("#chart circle").nth(1).focus();
  await page.keyboard.press("Enter");
  await page.waitForFunction(() => document.querySelector("#error-image").naturalWidth === 160);
  assert.ok(await page.isVisible("#error-image"));
  assert.match(await text(page, "#chart-details"), /standard.*relMSE/s);
  await pointsByKeyboard(v, page);
  await v.screenshot("desk-compare-error");
  await page.selectOption("#wipe-with", "reference");
  await page.click("#wipe-start");
  await page.waitForFunction(() => document.querySelector("#after").naturalWidth === 160);
  await page.locator("#stage").focus();
  await page.keyboard.press("ArrowLeft");  // another view: its images are hidden
  await v.settled();
  assert.ok(!await page.isVisible("#error-image"));
  assert.equal(await page.locator("#wipe-with option[value=reference]").count(), 0);
  await page.click("#chart-details button >> text=Use this setting");
  assert.equal((await v.settled()).accuracy.preset, "standard");
});

visit("the maps of reflectors can be shown", {}, async (v, page) => {
  await page.click("#tab-accuracy");
  await page.selectOption("[data-field=curved] select", "probe");
  await v.settled();
  await page.click("#tab-maps");
  await page.click("#maps-show");
  await page.waitForFunction(() => [...document.querySelectorAll("#maps img")].some((i) => i.naturalWidth > 0));
  assert.match(await text(page, "#maps"), /Ball/);
});
