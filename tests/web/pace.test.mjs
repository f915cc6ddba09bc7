// Size and accuracy of frames in motion and at rest, from sequences of milliseconds; and which frames the page requests, by
// events: no test waits for time.
import assert from "node:assert/strict";
import { test } from "node:test";

import { Problem } from "../../web/api.js";
import { Frames, accuracyKind, workMs } from "../../web/frames.js";
import { Pace, ladderOf } from "../../web/pace.js";

const cost = ({ scale, draft }) => scale * scale * (draft ? 0.6 : 1);

// Frames in motion on a machine with a fixed time and a time per pixel; the levels.
function motion(pace, { fixed = 0, full = 400 }, frames) {
  return Array.from({ length: frames }, () => {
    const level = pace.moving;
    pace.measured(level, fixed + full * cost(pace.ladder[level]));
    return level;
  });
}

test("each level of the ladder is cheaper than the one before, and the first is the full frame", () => {
  const ladder = ladderOf(1280, 720);
  assert.deepEqual(ladder[0], { scale: 1, draft: false });
  assert.equal(ladder.length, 8);
  for (let i = 1; i < ladder.length; ++i) assert.ok(cost(ladder[i]) < cost(ladder[i - 1]));
  assert.equal(ladderOf(64, 48).length, 1);
  assert.ok(ladderOf(1280, 720, "draft").every(({ draft }) => !draft));
  assert.ok(ladderOf(1280, 720, "budget").slice(1).every(({ draft }) => draft));
});

test("the kind of an accuracy", () => {
  const presets = ["draft", "standard"];
  assert.equal(accuracyKind("draft", presets), "draft");
  assert.equal(accuracyKind({ preset: "draft" }, presets), "draft");
  assert.equal(accuracyKind({ preset: "draft", generations: 3 }, presets), "other");
  assert.equal(accuracyKind({ preset: "standard", maxMilliseconds: 50 }, presets), "budget");
  assert.equal(accuracyKind(undefined, presets), "other");
});

test("waiting and compilation are not the work of a frame", () => {
  const timings = [{ name: "queue", milliseconds: 30 }, { name: "surface", milliseconds: 40 }, { name: "compile", milliseconds: 20 }];
  assert.equal(workMs({ milliseconds: 100, timings }), 50);
});

test("the first frame is the smallest, and the second one meets the target", () => {
  for (const full of [50, 400, 3000]) {
    const pace = new Pace(ladderOf(1280, 720), 100);
    assert.deepEqual(motion(pace, { full }, 1), [pace.ladder.length - 1]);
    assert.ok(full * cost(pace.ladder[pace.moving]) <= 100);
    if (pace.moving > 0) assert.ok(full * cost(pace.ladder[pace.moving - 1]) > 80);
  }
});

test("a full frame that was measured before gives the first level in motion", () => {
  const pace = new Pace(ladderOf(1280, 720), 100);
  assert.ok(pace.fullIsQuick, "unknown");
  pace.measured(0, 400);
  assert.ok(!pace.fullIsQuick);
  assert.ok(400 * cost(pace.ladder[pace.moving]) <= 80);
});

test("steady times keep the level; a slow frame alone does, too", () => {
  const pace = new Pace(ladderOf(1280, 720), 100);
  const levels = motion(pace, {}, 200);
  assert.deepEqual(new Set(levels.slice(20)).size, 1);
  const level = pace.moving;
  pace.measured(level, 150);
  assert.equal(pace.moving, level);
  pace.measured(level, 150);
  assert.ok(pace.moving > level);
});

test("a heavier view leads to smaller frames, and a lighter one back", () => {
  const pace = new Pace(ladderOf(1280, 720), 100);
  const light = motion(pace, {}, 20).at(-1);
  motion(pace, { full: 1600 }, 6);
  assert.ok(1600 * cost(pace.ladder[pace.moving]) <= 120);
  motion(pace, {}, 300);
  assert.equal(pace.moving, light);
});

test("a level that proved too slow is rarely tried again", () => {
  const pace = new Pace(ladderOf(1280, 720), 100);
  let slow = 0;
  for (let i = 0; i < 400; ++i) {
    const level = pace.moving;
    slow += level < 4;
    pace.measured(level, level >= 4 ? 50 : 130);
  }
  assert.ok(slow >= 2 && slow <= 20, String(slow));
});

test("a full frame comes in one step if it is quick, otherwise after a cheaper one", () => {
  for (const [full, steps] of [[150, 1], [500, 2], [3000, 2]]) {
    const pace = new Pace(ladderOf(1280, 720), 100);
    motion(pace, { full }, 10);
    const before = pace.moving;
    const levels = [];
    for (let level = before; level > 0;) {
      level = pace.refined(level);
      levels.push(level);
      pace.measured(level, full * cost(pace.ladder[level]));
    }
    assert.equal(levels.length, steps, String(full));
    assert.equal(levels.at(-1), 0);
    assert.equal(pace.moving, before);
  }
});

// ---- the requests of the page -------------------------------------------------------------------

const settled = () => new Promise((resolve) => setImmediate(resolve));

// A page whose frames end when the test says so. `pose` is what it shows.
function page(t, { reduced = false, fullMs = 400 } = {}) {
  t.mock.timers.enable({ apis: ["setTimeout"] });
  const made = { pose: 0, open: [], requests: [], ahead: [], light: undefined, shown: [], failed: [] };
  made.frames = new Frames({
    limits: { maxPixels: 1280 * 720, maxEdge: 4096 },
    presets: ["draft", "standard"],
    box: () => ({ width: 1280, height: 720, ratio: 1 }),
    reducedMotion: () => reduced,
    requestFor: ([width, height], { draft = false }) => ({ pose: made.pose, width, height, accuracy: draft ? "draft" : "standard" }),
    shown: async (frame, request, still, signal) => {
      made.shown.push({ ...request, still });
      await made.after?.(still, signal);
    },
    failed: (problem) => { made.failed.push(problem); },
    render: (request, explain, signal, headers) => new Promise((resolve, reject) => {
      if (headers) {
        made.ahead.push(request);
        return resolve({ milliseconds: 1, timings: [], accuracy: "" });
      }
      made.requests.push(request);
      const done = () => {
        made.open.shift();
        const milliseconds = (fullMs * request.width * request.height * (request.accuracy === "draft" ? 0.6 : 1)) / (1280 * 720);
        resolve({ milliseconds, timings: [], accuracy: "", light: made.light });
      };
      signal.addEventListener("abort", () => {
        made.open.shift();
        reject(new Problem({ title: "No response" }));
      });
      const fail = (problem) => {
        made.open.shift();
        reject(problem);
      };
      made.open.push({ request, explain, done, fail });
    }),
  });
  made.move = (pose) => {
    made.pose = pose;
    made.frames.moved();
  };
  made.finish = async () => {
    made.open[0].done();
    await settled();
  };
  made.rest = async () => {
    t.mock.timers.tick(200);
    await settled();
  };
  return made;
}

const isFull = ({ width, accuracy }) => width === 1280 && accuracy === "standard";

test("of the poses during a frame the newest is requested next, and one request is in progress", async (t) => {
  const p = page(t);
  for (let pose = 1; pose <= 5; ++pose) p.move(pose);
  assert.equal(p.open.length, 1);
  await p.finish();
  assert.deepEqual(p.requests.map(({ pose }) => pose), [1, 5]);
  assert.equal(p.open.length, 1);
  await p.finish();
  assert.deepEqual(p.shown.map(({ pose }) => pose), [1, 5]);
  assert.equal(p.open.length, 0, "nothing is requested twice");
});

test("the next pose is requested while a picture is decoded; pictures keep their order; none follows the end", async (t) => {
  const p = page(t), decoded = [];
  p.after = () => new Promise((resolve) => decoded.push(resolve));
  p.move(1);
  p.move(2);
  await p.finish();
  assert.deepEqual(p.requests.map(({ pose }) => pose), [1, 2]);
  p.move(3);
  await p.finish();
  assert.deepEqual(p.shown.map(({ pose }) => pose), [1], "the second picture waits for the first");
  decoded.shift()();
  await settled();
  assert.deepEqual(p.shown.map(({ pose }) => pose), [1, 2]);
  p.move(4);
  await p.finish();  // of pose 3
  p.frames.stop();
  decoded.shift()();
  await settled();
  assert.deepEqual(p.shown.map(({ pose }) => pose), [1, 2]);
});

test("pictures are shown after one that could not be", async (t) => {
  const p = page(t);
  p.after = async () => { throw new Problem({ status: 404, title: "Not found" }); };
  p.move(1);
  await p.finish();
  p.after = undefined;
  p.move(2);
  await p.finish();
  assert.deepEqual(p.shown.map(({ pose }) => pose), [1, 2]);
  assert.equal(p.failed.length, 1);
});

test("at rest the view is refined up to the full frame, with its plan", async (t) => {
  const p = page(t);
  p.move(1);
  await p.finish();
  assert.ok(!isFull(p.shown[0]) && !p.shown[0].still);
  assert.equal(p.open.length, 0);
  await p.rest();
  let steps = 0;
  for (; p.open.length > 0; ++steps) {
    assert.equal(p.open[0].explain, isFull(p.open[0].request) ? "1" : "0");
    await p.finish();
  }
  assert.ok(isFull(p.shown.at(-1)) && p.shown.at(-1).still);
  assert.ok(steps >= 1 && steps <= 2);
  await p.rest();
  assert.equal(p.open.length, 0, "complete");
});

test("a frame in motion is drawn in advance, once, when the light is complete", async (t) => {
  const p = page(t);
  const finishAll = async () => {
    while (p.open.length > 0) await p.finish();
  };
  p.light = { revision: 1, share: 0.5 };
  p.frames.begin();
  await finishAll();
  assert.equal(p.ahead.length, 0, "its maps would change with the light");
  for (let again = 0; again < 2; ++again) {
    p.light = { revision: 2, share: 1 };
    p.frames.refresh();
    await finishAll();
    assert.equal(p.ahead.length, 1);
  }
  p.move(7);
  assert.deepEqual(p.ahead[0], { ...p.open[0].request, pose: 0 }, "what the drag requests");
  assert.equal(p.shown.length, p.requests.length - 1, "it is not shown");
});

test("nothing is drawn in advance where full frames are quick", async (t) => {
  const p = page(t, { fullMs: 100 });
  p.frames.begin();
  while (p.open.length > 0) await p.finish();
  assert.equal(p.ahead.length, 0);
});

test("a pose aborts the refinement and is requested at once", async (t) => {
  const p = page(t);
  p.move(1);
  await p.finish();
  await p.rest();
  assert.equal(p.open.length, 1);
  p.move(2);
  await settled();
  assert.equal(p.open.length, 1);
  assert.equal(p.open[0].request.pose, 2);
  assert.ok(!isFull(p.open[0].request));
  assert.deepEqual(p.failed, [], "not an error");
  await p.finish();
  assert.equal(p.shown.at(-1).pose, 2);
});

test("a frame in motion is never aborted", async (t) => {
  const p = page(t);
  p.move(1);
  for (let pose = 2; pose < 40; ++pose) p.move(pose);
  assert.equal(p.requests.length, 1);
  await p.finish();
  assert.equal(p.shown[0].pose, 1);
});

test("rest that begins during a frame refines after it, not instead of the newest pose", async (t) => {
  const p = page(t);
  p.move(1);
  p.move(2);
  await p.rest();
  await p.finish();
  assert.equal(p.open[0].request.pose, 2);
  assert.ok(!isFull(p.open[0].request));
  await p.finish();
  assert.equal(p.open.length, 1, "the refinement");
});

test("a changed setting requests the full frame, unless that takes long", async (t) => {
  const quick = page(t, { fullMs: 100 });
  for (let i = 0; i < 3; ++i) {
    quick.frames.changed();
    assert.ok(isFull(quick.open[0].request));
    await quick.finish();
    assert.ok(quick.shown.at(-1).still);
  }
  t.mock.timers.reset();
  const slow = page(t, { fullMs: 1000 });
  slow.frames.changed();
  assert.ok(isFull(slow.open[0].request), "nothing is known yet");
  await slow.finish();
  slow.frames.changed();
  assert.ok(!isFull(slow.open[0].request));
  await slow.finish();
  await slow.rest();
  while (slow.open.length > 0) await slow.finish();
  assert.ok(slow.shown.at(-1).still);
});

test("a pose aborts the full frame after a changed setting, and what is requested after it", async (t) => {
  const p = page(t, { fullMs: 100 });
  p.frames.changed();
  assert.ok(isFull(p.open[0].request));
  p.move(1);
  await settled();
  assert.deepEqual([p.open.length, p.open[0].request.pose, isFull(p.open[0].request)], [1, 1, false]);
  await p.finish();
  await p.rest();
  // The other side of a comparison is requested while the full frame is being shown.
  p.after = (still, signal) => still && new Promise((resolve, reject) => signal.addEventListener("abort", () => reject(new Problem({}))));
  while (!p.shown.at(-1).still) await p.finish();
  assert.equal(p.open.length, 0);
  p.move(2);
  await settled();
  assert.equal(p.open[0].request.pose, 2, "at once");
  assert.deepEqual(p.failed, []);
});

test("another scene has a small frame at once, then the full one", async (t) => {
  const p = page(t, { fullMs: 3000 });
  p.frames.changed();
  p.frames.stop();
  await settled();
  assert.equal(p.open.length, 0, "frames of the scene before are aborted");
  p.pose = 7;
  p.frames.begin();
  const { pose, width, height, accuracy } = p.open[0].request;
  assert.deepEqual([pose, width, height, accuracy], [7, 320, 180, "draft"]);
  await p.finish();
  assert.ok(isFull(p.open[0].request), "without waiting for rest");
  await p.finish();
  assert.deepEqual(p.shown.map(({ still }) => still), [false, true]);
  assert.equal(p.open.length, 0);
  assert.deepEqual(p.failed, []);
});

test("another scene does not wait for the retry of the one before, which is not sent", async (t) => {
  const p = page(t);
  p.frames.changed();
  p.open[0].fail(new Problem({ status: 503 }, 5));
  await settled();
  p.frames.changed();
  assert.equal(p.open.length, 0, "the server is busy");
  p.pose = 7;
  p.frames.begin();
  assert.equal(p.open[0]?.request.pose, 7);
  while (p.open.length > 0) await p.finish();
  assert.ok(p.shown.at(-1).still);
  const sent = p.requests.length;
  t.mock.timers.tick(6000);
  await settled();
  assert.equal(p.requests.length, sent);
});

test("a frame whose scene was left while it arrived is not shown", async (t) => {
  const p = page(t);
  p.move(1);
  p.open[0].done();
  p.frames.stop();
  await settled();
  assert.deepEqual(p.shown, []);
});

test("with reduced motion every frame is full", async (t) => {
  const p = page(t, { reduced: true });
  for (let pose = 1; pose <= 3; ++pose) p.move(pose);
  await p.finish();
  await p.finish();
  await p.rest();
  assert.deepEqual(p.shown.map(({ pose, still }) => [pose, still]), [[1, true], [3, true]]);
  assert.equal(p.open.length, 0);
});
