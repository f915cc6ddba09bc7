// A Clerestory server and a real Chromium for the page's tests.
import assert from "node:assert/strict";
import { mkdirSync } from "node:fs";
import { join } from "node:path";
import { after, before, test } from "node:test";

import { near } from "../near.mjs";
import { killServers, serve } from "../server_process.mjs";
import { launch } from "./chromium.mjs";

const screenshotFolder = process.env.CLERESTORY_SCREENSHOTS;

let browser;

const kDesk = { width: 1280, height: 800 };

// A page in its own browser context that records requests and errors.
export class Visit {
  frames = [];        // bodies of POST v1/frames, in order
  first;              // that of the first full frame
  foreign = [];       // requests to other origins
  errors = [];        // of the console, and uncaught ones
  #inProgress = new Set();   // requests of frames that are shown
  #ahead = new Set();        // of others
  #runningAtStart = [];      // for each request of a frame, those in progress when it began
  #failed = new Set();       // aborted, or without an answer
  expected = [/409/]; // allowed errors: a scene that is still loading is 409

  static async open(url, { viewport = kDesk, before, path = "", ...options } = {}) {
    const visit = new Visit();
    visit.context = await browser.newContext({ viewport, ...options });
    await visit.context.grantPermissions(["clipboard-read", "clipboard-write"]);
    visit.page = await visit.context.newPage();
    visit.page.setDefaultTimeout(300000);
    visit.#watch(new URL(url).origin);
    await before?.(visit.page);
    await visit.page.goto(url + path);
    return visit;
  }

  #watch(origin) {
    const { page } = this;
    const isFrame = (request) => request.method() === "POST" && new URL(request.url()).pathname === "/v1/frames" &&
      request.postDataJSON().width > 1 && !request.postDataJSON().output?.channel;
    const isAhead = (request) => request.headers().priority?.startsWith("u=6");  // drawn in advance, not shown
    page.on("request", (request) => {
      const { protocol, origin: to } = new URL(request.url());
      if (to !== origin && !["blob:", "data:"].includes(protocol)) this.foreign.push(request.url());
      if (!isFrame(request)) return;
      if (isAhead(request)) return this.#ahead.add(request);
      this.frames.push(request.postDataJSON());
      this.#runningAtStart.push([...this.#inProgress]);
      this.#inProgress.add(request);
    });
    page.on("requestfinished", (request) => this.#ended(request));
    page.on("requestfailed", (request) => {
      this.#ended(request);
      this.#failed.add(request);
    });
    page.on("pageerror", (error) => this.errors.push(String(error)));
    page.on("console", (message) => {
      if (["error", "warning"].includes(message.type())) this.errors.push(message.text());
    });
  }

  // Waits until the full frame of the present settings is shown and no request is in flight.
  async settled() {
    await this.page.waitForFunction(() => document.querySelector("#frame").src && document.querySelector("#note").hidden &&
      !document.querySelector("#stage").classList.contains("moving"));
    for (let quiet = 0; quiet < 8;) {
      const before = this.frames.length;
      await new Promise((resolve) => setTimeout(resolve, 40));
      quiet = this.running === 0 && this.frames.length === before ? quiet + 1 : 0;
    }
    return this.frames.at(-1);
  }

  async screenshot(name) {
    if (!screenshotFolder) return;
    mkdirSync(screenshotFolder, { recursive: true });
    await this.page.screenshot({ animations: "disabled", path: join(screenshotFolder, `${name}.png`) });
  }

  #ended(request) {
    this.#inProgress.delete(request);
    this.#ahead.delete(request);
  }

  get running() {
    return this.#inProgress.size + this.#ahead.size;
  }

  // The most requests in progress at the same time. The browser reports the end of an aborted request late, so those that
  // failed do not count as in progress when another one starts.
  get mostRunning() {
    return Math.max(0, ...this.#runningAtStart.map((others) => 1 + others.filter((r) => !this.#failed.has(r)).length));
  }

  async leave() {
    await this.context.close();
    assert.deepEqual(this.foreign, [], "requests to other origins");
    assert.deepEqual(this.errors.filter((text) => !this.expected.some((e) => e.test(text))), [], "errors");
    assert.ok(this.mostRunning <= 1, "one frame at a time");
  }
}

// ---- setup of every test file -------------------------------------------------------------------

export let server;
before(async () => {
  [server, browser] = await Promise.all([serve(), launch()]);
});
after(async () => {
  await browser?.close();
  await server?.stop();
  killServers();
});

// Opens the page, waits for the first full frame, runs the steps, and checks the recorded requests and errors.
export const visit = (name, options, steps) => test(name, { timeout: 600000 }, async () => {
  const visited = await Visit.open(options.url ?? server.url, options);
  visited.first = await visited.settled();
  await steps(visited, visited.page);
  await visited.leave();
});

export const distance = (a, b) => Math.hypot(...a.map((x, i) => x - b[i]));
export const same = (a, b) => near([...a.position, ...a.target, a.yfov], [...b.position, ...b.target, b.yfov], 1e-4);
export const text = (page, selector) => page.textContent(selector);
