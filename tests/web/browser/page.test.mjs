// The page in a real browser against a real server.
import assert from "node:assert/strict";
import { mkdtempSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, test } from "node:test";

import { near } from "../near.mjs";
import { Visit, close, freePort, launch, serve } from "./support.mjs";

let server;
before(async () => {
  [server] = await Promise.all([serve(), launch()]);
});
after(async () => {
  await close();
  await server?.stop();
});

// Opens, waits for the first full frame, runs the steps, and checks what holds everywhere.
const visit = (name, options, steps) => test(name, { timeout: 120000 }, async () => {
  const visited = await Visit.open(options.url ?? server.url, options);
  if (options.rests !== false) await visited.rest();
  await steps(visited, visited.page);
  await visited.leave();
});

const distance = (a, b) => Math.hypot(...a.map((x, i) => x - b[i]));
const same = (a, b) => near([...a.position, ...a.target, a.yfov], [...b.position, ...b.target, b.yfov], 1e-4);
const text = (page, selector) => page.textContent(selector);

visit("the first frame comes with what it cost and why", {}, async (v, page) => {
  assert.equal(v.frames.length, 1);
  assert.match(await text(page, "#caption"), /\d+ × \d+ · .* ms/);
  await page.click("#tab-cost");
  assert.ok(await page.locator("#rows > li").count() >= 3);
  assert.match(await text(page, "#decisions"), /Ball/);
  await page.locator("#decisions summary").first().click();
  assert.match(await text(page, "#decisions table"), /error \d/);
  const bars = await page.locator("#rows .full").evaluateAll((all) => all.map((r) => r.getBoundingClientRect().width));
  assert.ok(Math.max(...bars) > 200 && bars.some((width) => width < 100), `${bars}`);
  const picture = await page.locator("#frame").evaluate((i) => [i.naturalWidth, i.naturalHeight]);
  assert.deepEqual(picture, [v.frames[0].width, v.frames[0].height]);
});

visit("while dragging, one frame at a time and the newest pose wins; small ones, then the full one", {}, async (v, page) => {
  const full = v.frames[0];
  await page.route("**/v1/frames*", async (route) => {
    await new Promise((resolve) => setTimeout(resolve, 120));
    await route.continue();
  });
  const box = await page.locator("#stage").boundingBox();
  await page.mouse.move(box.x + 300, box.y + 300);
  await page.mouse.down();
  for (let i = 1; i <= 60; ++i) await page.mouse.move(box.x + 300 + 3 * i, box.y + 300);
  await page.mouse.up();
  const last = await v.rest();
  assert.ok(v.frames.length < 40, `${v.frames.length} frames for 60 movements`);
  assert.ok(v.frames.some((f) => f.width * f.height < 0.5 * full.width * full.height), "small ones while moving");
  assert.deepEqual([last.width, last.height], [full.width, full.height]);
  // 180 pixels over the shorter side are so many radians, about the target.
  const turned = (180 / Math.min(box.width, box.height)) * Math.PI;
  const yaw = ({ position: p, target: t }) => Math.atan2(p[0] - t[0], p[2] - t[2]);
  const difference = Math.abs(yaw(full.camera) - yaw(last.camera));
  near([Math.min(difference, 2 * Math.PI - difference)], [turned], 1e-3);
  near([distance(last.camera.position, last.camera.target)], [distance(full.camera.position, full.camera.target)], 1e-3);
});

const kLater = 600_000;  // on that clock, milliseconds

// Keys at moments of a clock that the test turns, frames at a rate of its own.
async function flown(rate, keys) {
  const v = await Visit.open(server.url, { before: async (page) => {
    await page.clock.install({ time: 0 });
    await page.addInitScript((hertz) => {
      window.requestAnimationFrame = (draw) => setTimeout(() => draw(performance.now()), 1000 / hertz);
    }, rate);
  } });
  const { page } = v;
  const start = (await v.rest()).camera;
  await page.focus("#stage");
  await page.clock.pauseAt(kLater);
  for (const [act, key, milliseconds] of keys) {
    await page.keyboard[act](key);
    await page.clock.runFor(milliseconds);
  }
  await page.clock.runFor(4000);
  await page.clock.resume();
  await v.rest();
  const end = v.frames.at(-1).camera;
  await v.leave();
  return { start, end, way: distance(start.position, end.position) };
}

test("the same keys fly the same path at 30 and at 144 frames a second", { timeout: 120000 }, async () => {
  const keys = [["down", "w", 300], ["down", "d", 250], ["up", "w", 200], ["up", "d", 0]];
  const slow = await flown(30, keys), fast = await flown(144, keys);
  assert.ok(slow.way > 0.2, `${slow.way}`);
  same(slow.end, fast.end);
});

test("a diagonal is no faster than straight ahead", { timeout: 120000 }, async () => {
  const ahead = await flown(60, [["down", "w", 400], ["up", "w", 0]]);
  const diagonal = await flown(60, [["down", "w", 0], ["down", "d", 400], ["up", "w", 0], ["up", "d", 0]]);
  assert.ok(ahead.way > 0.2);
  near([diagonal.way], [ahead.way], 2e-3);
});

visit("by keyboard alone: to the picture, turning, panning, zooming, an effect, the tabs", {}, async (v, page) => {
  const start = v.frames.at(-1);
  const focused = () => page.evaluate(() => document.activeElement.id);
  for (let i = 0; i < 8 && await focused() !== "stage"; ++i) await page.keyboard.press("Tab");
  assert.equal(await focused(), "stage");
  for (const [key, changes] of [["ArrowLeft", "position"], ["Shift+ArrowUp", "target"], ["+", "position"]]) {
    const before = (await v.rest()).camera;
    await page.keyboard.press(key);
    assert.ok(distance((await v.rest()).camera[changes], before[changes]) > 1e-3, key);
  }
  await page.keyboard.press("r");
  await page.waitForTimeout(400);
  same((await v.rest()).camera, start.camera);
  for (let i = 0; i < 12 && await focused() !== "tab-view"; ++i) await page.keyboard.press("Tab");
  await page.keyboard.press("ArrowRight");
  assert.equal(await focused(), "tab-accuracy");
  assert.ok(await page.isVisible("#panel-accuracy") && !await page.isVisible("#panel-view"));
  await page.keyboard.press("Tab");
  await page.keyboard.press("ArrowRight");  // the preset after standard
  assert.equal((await v.rest()).accuracy.preset, "fine");
  await page.click("#tab-view");
  await page.focus("#effects input");
  await page.keyboard.press("Space");
  assert.equal((await v.rest()).effects.emission, false);
});

visit("every control has a name of its own", {}, async (v, page) => {
  await page.check("input[value=fly]", { force: true });
  await page.click("#help");
  if (await page.isVisible("#add-filter")) {
    for (const { value } of await page.locator("#add-filter option").evaluateAll((all) => all.map((o) => ({ value: o.value })))) {
      if (value) await page.selectOption("#add-filter", value);
    }
    await v.rest();
  }
  const nameless = await page.evaluate(() => [...document.querySelectorAll("button, input, select, [role]:not(option), a[href]")]
    .filter((e) => {
      const named = e.getAttribute("aria-label") || e.labels?.length && [...e.labels].some((l) => l.textContent.trim()) ||
        document.getElementById(e.getAttribute("aria-labelledby"))?.textContent.trim() || e.textContent.trim();
      return !named && !["status", "presentation"].includes(e.getAttribute("role"));
    }).map((e) => e.outerHTML.slice(0, 120)));
  assert.deepEqual(nameless, []);
  const ids = await page.evaluate(() => [...document.querySelectorAll("[id]")].map((e) => e.id));
  assert.equal(new Set(ids).size, ids.length, "an id stands twice");
});

visit("a double click makes what was pointed at the centre of turning", {}, async (v, page) => {
  const before = v.frames.at(-1).camera;
  await page.dblclick("#stage");
  await page.waitForTimeout(500);
  const { position, target } = (await v.rest()).camera;
  near([Math.hypot(...target)], [0.5], 0.01);  // the ball of six-walls
  near([distance(position, before.position) + distance(position, target)], [distance(before.position, target)], 1e-3);
  assert.ok(distance(position, target) < 0.7 * distance(before.position, target));
});

visit("a link gives the same view and settings; so do curl and JSON", {}, async (v, page) => {
  await page.focus("#stage");
  await page.keyboard.press("ArrowLeft");
  await page.click("[data-field=planarReflection] input");
  await page.fill("[data-field=exposure] input[type=number]", "-0.5");
  await page.locator("[data-field=exposure] input[type=number]").blur();
  await page.click("#tab-accuracy");
  await page.fill("[data-field=generations] input[type=number]", "3");
  await page.locator("[data-field=generations] input[type=number]").blur();
  await page.click("#tab-view");
  const asked = await v.rest();
  assert.deepEqual([asked.exposure, asked.accuracy.generations, asked.effects.planarReflection], [-0.5, 3, false]);
  const copied = async (id) => {
    await page.click(id);
    await page.waitForFunction(() => document.querySelector("#copied").textContent.startsWith("Copied"));
    return page.evaluate(() => navigator.clipboard.readText());
  };
  assert.deepEqual(JSON.parse(await copied("#copy-json")), asked);
  const curl = await copied("#copy-curl");
  assert.deepEqual(JSON.parse(/-d '(.*)' -o/s.exec(curl)[1]), asked);
  const picture = await (await fetch(await copied("#copy-picture"))).arrayBuffer();
  const posted = await (await fetch(`${server.url}v1/frames`, {
    method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify(asked) })).arrayBuffer();
  assert.deepEqual(Buffer.from(picture), Buffer.from(posted));
  const other = await Visit.open(await copied("#copy-link"));
  const again = await other.rest();
  same(again.camera, asked.camera);
  assert.deepEqual({ ...again, camera: 0 }, { ...asked, camera: 0 });
  await other.leave();
});

visit("a full frame that nobody will see any more is given up", {}, async (v, page) => {
  v.mayRun = 2;  // the browser tells of the end of what was given up after the next has begun
  let given = 0;
  page.on("requestfailed", (request) => { given += request.url().includes("explain=1"); });
  await page.route("**/v1/frames?explain=1", async (route) => {
    await new Promise((resolve) => setTimeout(resolve, 800));
    await route.continue().catch(() => {});
  });
  await page.focus("#stage");
  await page.keyboard.press("ArrowLeft");
  await page.waitForRequest((r) => r.url().includes("explain=1"));
  await page.keyboard.press("ArrowLeft");
  await v.rest();
  assert.equal(given, 1);
});

visit("filters are added, ordered and taken away, and a link keeps them", {}, async (v, page) => {
  await page.selectOption("#add-filter", "twirl");
  await page.selectOption("#add-filter", "convolve");
  assert.deepEqual((await v.rest()).filters, [{ type: "twirl", amount: 1 }, { type: "convolve", kernel: "sharpen" }]);
  await page.fill("#filters [data-field=amount] input[type=number]", "2.5");
  await page.locator("#filters [data-field=amount] input[type=number]").blur();
  await page.click("#filters li:nth-child(2) [aria-label=Earlier]");
  const asked = await v.rest();
  assert.deepEqual(asked.filters, [{ type: "convolve", kernel: "sharpen" }, { type: "twirl", amount: 2.5 }]);
  const other = await Visit.open(page.url());
  assert.deepEqual((await other.rest()).filters, asked.filters);
  await other.leave();
  await page.click("#filters [aria-label=Remove]");
  assert.deepEqual((await v.rest()).filters, [{ type: "twirl", amount: 2.5 }]);
});

visit("others can watch the view live", {}, async (v, page) => {
  const put = page.waitForRequest((r) => r.method() === "PUT");
  await page.click("#live");
  assert.deepEqual((await put).postDataJSON(), await v.rest());
  const place = new URL(await page.getAttribute("#live-link", "href"));
  const view = await (await fetch(`${server.url}v1/views/${place.searchParams.get("view")}`)).json();
  assert.deepEqual(view.camera, v.frames.at(-1).camera);
});

visit("a busy server is told about, waited for and asked again", {}, async (v, page) => {
  v.expected.push(/503/);
  let refusals = 0;
  await page.route("**/v1/frames*", (route) => (refusals++ < 1
    ? route.fulfill({ status: 503, headers: { "Retry-After": "2" }, contentType: "application/problem+json",
                      body: JSON.stringify({ title: "Queue full", status: 503, detail: "As many frames wait as may wait." }) })
    : route.continue()));
  await page.click("[data-field=emission] input");
  await page.waitForSelector("#note:not([hidden])");
  assert.match(await text(page, "#note"), /The server is busy.*As many frames wait.*Trying again in [12] s/s);
  await v.picture("busy");
  await page.click("[data-field=refraction] input");  // is not sent meanwhile
  assert.equal((await v.rest()).effects.refraction, false);
  assert.equal(refusals, 2);
});

visit("a frame over the deadline comes with fewer pixels", {}, async (v, page) => {
  v.expected.push(/504/);
  const full = v.frames[0].width * v.frames[0].height;
  await page.route("**/v1/frames*", (route) => {
    const { width, height } = route.request().postDataJSON();
    return width * height > 0.3 * full
      ? route.fulfill({ status: 504, contentType: "application/problem+json",
                        body: JSON.stringify({ title: "Over the deadline", status: 504, detail: "Not done within 10 seconds." }) })
      : route.continue();
  });
  await page.click("[data-field=emission] input");
  const last = await v.rest();
  assert.ok(last.width * last.height > 0.2 * full && last.width * last.height < 0.3 * full);
  await page.unroute("**/v1/frames*");
  await page.click("[data-field=emission] input");
  assert.equal((await v.rest()).width, v.frames[0].width);
});

visit("a refusal says which field and what would be right", {}, async (v, page) => {
  v.expected.push(/422/);
  await page.evaluate(() => { document.querySelector("[data-field=map] select").append(new Option("nowhere", "nowhere")); });
  await page.selectOption("[data-field=map] select", "nowhere");
  await page.waitForSelector("#note.bad");
  assert.match(await text(page, "#note"), /refuses.*\/environment\/map there is no such environment map.*one of: /s);
});

test("a server that goes away and comes back is waited for", { timeout: 120000 }, async () => {
  const port = await freePort();
  const first = await serve({ port });
  const v = await Visit.open(first.url);
  v.expected.push(/Failed to load resource|ERR_/);
  await v.rest();
  await first.stop();
  await v.page.click("[data-field=emission] input");
  await v.page.waitForSelector("#note.bad");
  assert.match(await text(v.page, "#note"), /does not answer.*restarting.*Trying again/s);
  const second = await serve({ port });
  assert.equal((await v.rest()).effects.emission, false);
  await v.leave();
  await second.stop();
});

test("a server that asks for a token gets it with every request, pictures and all", { timeout: 120000 }, async () => {
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
  await v.rest();
  await page.reload();
  await v.rest();
  assert.ok(!await page.isVisible("#token-form"));
  await v.leave();
  await guarded.stop();
});

visit("where motion is unwelcome nothing glides, and every frame is a full one", { reducedMotion: "reduce" }, async (v, page) => {
  const full = v.frames[0];
  await page.dblclick("#stage");
  await v.rest();
  await page.focus("#stage");
  await page.keyboard.press("w", { delay: 120 });
  const { length } = v.frames;
  await v.rest();
  assert.ok(v.frames.every((f) => f.width === full.width && f.accuracy.preset), "full ones only");
  assert.ok(v.frames.length - length <= 3, "it stops with the key");
  assert.equal(await page.evaluate(() => getComputedStyle(document.querySelector("button")).transitionDuration), "0s");
});

visit("fingers turn and pinch; the pad flies", { hasTouch: true, isMobile: true, viewport: { width: 390, height: 844 } }, async (v, page) => {
  const touch = await page.context().newCDPSession(page);
  const send = (type, ...points) => touch.send("Input.dispatchTouchEvent", { type, touchPoints: points.map(([x, y], id) => ({ x, y, id })) });
  const start = v.frames[0].camera;
  const box = await page.locator("#stage").boundingBox();
  const [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
  await send("touchStart", [x, y]);
  for (let i = 1; i <= 5; ++i) await send("touchMove", [x + 10 * i, y]);
  await send("touchEnd");
  const turned = (await v.rest()).camera;
  near(turned.target, start.target, 1e-6);
  assert.ok(distance(turned.position, start.position) > 0.1);
  await send("touchStart", [x - 30, y], [x + 30, y]);
  for (let i = 1; i <= 5; ++i) await send("touchMove", [x - 30 - 6 * i, y], [x + 30 + 6 * i, y]);
  await send("touchEnd");
  const pinched = (await v.rest()).camera;
  near([distance(pinched.position, pinched.target) / distance(turned.position, turned.target)], [0.5], 0.01);
  await page.check("input[value=fly]", { force: true });
  await page.locator("[data-code=KeyE]").click({ delay: 200 });
  assert.ok((await v.rest()).camera.position[1] > pinched.position[1] + 0.01);
  const wide = await page.evaluate(() => [document.scrollingElement.scrollWidth, innerWidth]);
  assert.ok(wide[0] <= wide[1], `the page is ${wide[0]} wide on ${wide[1]}`);
});

visit("two settings lie beside each other and the line moves, by key too", {}, async (v, page) => {
  await page.click("#tab-compare");
  await page.click("#wipe-start");
  await page.waitForSelector("#wipe", { state: "visible" });
  await v.rest();
  assert.deepEqual(Object.values(v.frames.at(-1).effects), [false, false, false, false]);
  const edge = () => page.locator("#wipe-line").evaluate((e) => e.getBoundingClientRect().left);
  const before = await edge();
  await page.focus("#wipe");
  for (let i = 0; i < 20; ++i) await page.keyboard.press("ArrowRight");
  assert.ok(await edge() > before + 50);
  await page.selectOption("#wipe-with", "preset:draft");
  assert.equal((await v.rest()).accuracy, "draft");
  await page.click("#wipe-start");
  await v.rest();
  assert.ok(!await page.isVisible("#after"));
});

visit("accuracy against time of this view: a chart, error pictures, and the truth in the wipe", {}, async (v, page) => {
  await page.click("#tab-compare");
  await page.selectOption("#truth-samples", "4");
  await page.selectOption("#truth-edge", "160");
  await page.click("#measure");
  await page.waitForSelector("#chart circle");
  assert.equal(await page.locator("#chart circle").count(), 3);
  assert.ok((await page.locator("#chart .hull").getAttribute("points")).trim().length > 0);
  await page.locator("#chart circle").nth(1).focus();
  await page.keyboard.press("Enter");
  await page.waitForFunction(() => document.querySelector("#error-picture").naturalWidth === 160);
  assert.ok(await page.isVisible("#error-picture"));
  assert.match(await text(page, "#chart-details"), /standard.*relMSE/s);
  await v.picture("desk-compare-error");
  await page.selectOption("#wipe-with", "truth");
  await page.click("#wipe-start");
  await page.waitForFunction(() => document.querySelector("#after").naturalWidth === 160);
  await page.locator("#stage").focus();
  await page.keyboard.press("ArrowLeft");  // another view: its pictures go
  await v.rest();
  assert.ok(!await page.isVisible("#error-picture"));
  assert.equal(await page.locator("#wipe-with option[value=truth]").count(), 0);
  await page.click("#chart-details button >> text=Use this setting");
  assert.equal((await v.rest()).accuracy.preset, "standard");
});

visit("the maps that mirrors look at can be seen", {}, async (v, page) => {
  await page.click("#tab-accuracy");
  await page.selectOption("[data-field=curved] select", "probe");
  await v.rest();
  await page.click("#tab-maps");
  await page.click("#maps-show");
  await page.waitForFunction(() => [...document.querySelectorAll("#maps img")].some((i) => i.naturalWidth > 0));
  assert.match(await text(page, "#maps"), /Ball/);
});

visit("a scene says how far it is while it loads; nothing of it moves, so there is no time slider; nobody may upload",
      {}, async (v, page) => {
  let polls = 0;
  await page.route("**/v1/scenes/teapots", async (route) => (polls++ < 2
    ? route.fulfill({ json: { id: "teapots", state: "loading", stage: "cutting clusters", progress: 0.4 } }) : route.continue()));
  await page.selectOption("#scene", "teapots");
  await page.waitForFunction(() => document.querySelector("#note progress:not([hidden])")?.value === 0.4);
  assert.match(await text(page, "#note"), /Loading teapots.*cutting clusters/s);
  await page.waitForFunction(() => location.hash.includes("scene=teapots"));
  assert.equal((await v.rest()).scene, "teapots");
  assert.ok(!await page.isVisible("#time-row"));
  assert.ok(!await page.isVisible("#upload-pick"));
});

visit("where a scene lists clips its time plays; where files may come they are sent", { rests: false, before: async (page) => {
  await page.route("**/v1/scenes/six-walls", async (route) => {
    const scene = await (await route.fetch()).json();
    await route.fulfill({ json: { ...scene, animations: [{ name: "swing", duration: 2 }] } });
  });
  await page.route("**/openapi.json", async (route) => {
    const schema = await (await route.fetch()).json();
    schema.paths["/v1/scenes"].post = {};
    await route.fulfill({ json: schema });
  });
} }, async (v, page) => {
  await v.rest();
  await page.click("#play");
  await page.waitForFunction(() => Number(document.querySelector("#time").value) > 0.2);
  await page.click("#play");
  const { time } = await v.rest();
  assert.ok(time > 0.2 && time < 2);
  assert.ok(v.frames.filter((f) => f.time > 0).length > 1);
  const sent = page.waitForRequest((r) => r.method() === "POST" && r.url().endsWith("/v1/scenes"));
  await page.route("**/v1/scenes", async (route) => (route.request().method() === "POST"
    ? route.fulfill({ status: 201, headers: { Location: "/v1/scenes/six-walls" }, json: { id: "six-walls" } }) : route.continue()));
  await page.setInputFiles("#upload", { name: "box.glb", mimeType: "model/gltf-binary", buffer: Buffer.from("glTF") });
  assert.equal((await sent).headers()["content-type"], "model/gltf-binary");
  await v.rest();
});

test("the page forbids what it does not need", async () => {
  const policy = (await fetch(server.url)).headers.get("Content-Security-Policy");
  assert.match(policy, /default-src 'self'/);
  assert.doesNotMatch(policy, /unsafe/);
});

// ---- pictures, to be looked at ------------------------------------------------------------------

const looks = [
  ["desk-light", { colorScheme: "light", viewport: { width: 1360, height: 850 } }],
  ["desk-dark", { colorScheme: "dark", viewport: { width: 1360, height: 850 } }],
  ["phone-light", { colorScheme: "light", viewport: { width: 390, height: 844 }, hasTouch: true, isMobile: true, deviceScaleFactor: 2 }],
  ["phone-dark", { colorScheme: "dark", viewport: { width: 390, height: 844 }, hasTouch: true, isMobile: true, deviceScaleFactor: 2 }],
];
for (const [name, options] of looks) {
  visit(`it looks well: ${name}`, { ...options, path: "#scene=chapel" }, async (v, page) => {
    for (const tab of ["view", "accuracy", "cost", "compare", "maps"]) {
      await page.click(`#tab-${tab}`);
      if (tab === "maps") {
        await page.click("#maps-show");
        await page.waitForFunction(() => [...document.querySelectorAll("#maps img")].every((i) => i.naturalWidth > 0) &&
          document.querySelectorAll("#maps img").length > 2);
      }
      await v.picture(`${name}-${tab}`);
      const cut = await page.evaluate(() => [...document.querySelectorAll("aside button, aside label, aside h2, header label")]
        .filter((e) => e.offsetParent && e.scrollWidth > e.clientWidth + 1 && getComputedStyle(e).display !== "inline").map((e) => e.textContent));
      assert.deepEqual(cut, [], "words that do not fit");
    }
  });
}
