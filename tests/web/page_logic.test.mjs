// The page's pure parts, without a browser: camera mathematics, gestures, pace, headers, links.
import assert from "node:assert/strict";
import { test } from "node:test";

import { curlOf, decisionText, parseServerTiming, queryOf, rounded } from "../../web/api.js";
import { forwardOf, fromLookAt, lensFor, orbit, pan, positionOf, walk, zoom } from "../../web/camera.js";
import { gestureOf, wheelZoom } from "../../web/gestures.js";
import { Latest, frameSize, movingPixels } from "../../web/pace.js";

const near = (actual, expected, bound = 1e-9) =>
  actual.forEach((x, i) => assert.ok(Math.abs(x - expected[i]) <= bound, `${actual} is not ${expected}`));

const view = { position: [3, 4, 5], target: [0, 1, 0], yfov: 0.9 };

test("an orbit camera stands where its look-at says", () => near(positionOf(fromLookAt(view)), view.position));

test("a full turn comes back and keeps the distance", () => {
  let camera = fromLookAt(view);
  for (let i = 0; i < 8; ++i) {
    camera = orbit(camera, Math.PI / 4, 0);
    assert.ok(Math.abs(Math.hypot(...positionOf(camera).map((x, k) => x - camera.target[k])) - Math.sqrt(43)) < 1e-9);
  }
  near(positionOf(camera), view.position);
});

test("no drag turns the camera past straight up or down", () => {
  for (const dy of [100, -100]) {
    const { pitch } = orbit(fromLookAt(view), 0, dy);
    assert.ok(Math.abs(pitch) < Math.PI / 2);
  }
});

test("panning by the whole side moves what is at the target's depth by the whole side", () => {
  const camera = fromLookAt({ position: [0, 0, 2], target: [0, 0, 0], yfov: Math.PI / 2 });
  near(pan(camera, 1, 0).target, [-4, 0, 0]);
  near(pan(camera, 0, 1).target, [0, 4, 0]);
});

test("zooming in and out by the same factor is nothing", () =>
  near(positionOf(zoom(zoom(fromLookAt(view), 1.3), 1 / 1.3)), view.position));

test("walking ahead goes where the camera looks, on the level", () => {
  const camera = walk(fromLookAt({ position: [0, 5, 5], target: [0, 0, 0], yfov: 1 }), 2, 0, 0);
  near(positionOf(camera), [0, 5, 3]);
});

test("the identity looks down -Z, a quarter turn about Y down -X", () => {
  near(forwardOf([0, 0, 0, 1]), [0, 0, -1]);
  near(forwardOf([0, Math.SQRT1_2, 0, Math.SQRT1_2]), [-1, 0, 0]);
});

test("an upright picture keeps its width in view", () => {
  assert.equal(lensFor(1, 1.5), 1);
  assert.ok(Math.abs(Math.tan(lensFor(1, 0.5) / 2) * 0.5 - Math.tan(0.5)) < 1e-9);
});

test("one finger turns, two fingers pan and zoom", () => {
  assert.deepEqual(gestureOf([[0, 0]], [[100, 0]], 100), { kind: "orbit", dx: Math.PI, dy: 0 });
  const pinch = gestureOf([[0, 0], [10, 0]], [[-5, 0], [15, 0]], 100);
  assert.deepEqual([pinch.kind, pinch.dx, pinch.zoom], ["pan", 0, 0.5]);
  assert.equal(gestureOf([[5, 5], [5, 5]], [[5, 5], [5, 5]], 100).zoom, 1);
  assert.ok(wheelZoom(100, 0) > 1 && wheelZoom(-3, 1) < 1);
});

test("only the newest of many wishes runs after the one under way", async () => {
  const ran = [];
  let release;
  const gate = new Promise((resolve) => { release = resolve; });
  const latest = new Latest(async (wish) => {
    ran.push(wish);
    if (wish === 1) await gate;
  });
  for (const wish of [1, 2, 3, 4]) latest.ask(wish);
  release();
  await new Promise((resolve) => setTimeout(resolve));
  assert.deepEqual(ran, [1, 4]);
});

test("a frame keeps its shape within the limits", () => {
  assert.deepEqual(frameSize(100, 50, 2, { maxPixels: 1e6, maxEdge: 4096 }), [200, 100]);
  const [width, height] = frameSize(4000, 2000, 2, { maxPixels: 1280 * 720, maxEdge: 4096 });
  assert.ok(width * height <= 1280 * 720 && Math.abs(width / height - 2) < 0.01);
});

test("moving frames follow the budget within their limits", () => {
  const limits = { least: 100, most: 10000 };
  assert.equal(movingPixels({ pixels: 1000, milliseconds: 200 }, 100, limits), 500);
  assert.equal(movingPixels({ pixels: 1000, milliseconds: 1 }, 100, limits), 2000);
  assert.equal(movingPixels({ pixels: 120, milliseconds: 1000 }, 100, limits), 100);
});

test("Server-Timing is read with and without descriptions", () =>
  assert.deepEqual(parseServerTiming('queue;dur=0.1, surface;desc="a, b";dur=41.5, odd'),
                   [{ name: "queue", milliseconds: 0.1 }, { name: "surface", milliseconds: 41.5 }]));

test("a decision is a sentence that names who is served, how and why", () => {
  const decision = { name: "mirror:floor", taken: "mirror", reason: "12.0 % of the frame, 30.0 ms predicted" };
  assert.equal(decisionText(decision), "floor: mirrored pass, 12.0 % of the frame, 30.0 ms predicted");
  assert.equal(decisionText({ name: "pane", taken: "new", reason: "why" }), "pane: new, why");
});

test("a request becomes a link and a command", () => {
  const request = rounded({ scene: "a b", camera: { position: [1, 2.00000001, 3] }, effects: { emission: false } });
  assert.equal(queryOf(request), "scene=a%20b&camera.position=1,2,3&effects.emission=false");
  assert.ok(curlOf({ scene: "it's" }, "http://h").includes(`it'\\''s`));
});
