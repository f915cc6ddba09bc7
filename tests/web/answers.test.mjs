// Responses: headers, multipart bodies, NumPy files, plans, problems, comparisons; and the scheduling of requests.
import assert from "node:assert/strict";
import { test } from "node:test";

import { floatsOf, lightChanged, lightOf, parseServerTiming, partsOf, relativePath } from "../../web/api.js";
import { hullOf, logAxis, logTicks, settingsFor, shortNumber } from "../../web/compare_panel.js";
import { decisionRows, planRows, skippedRows, timeParts } from "../../web/frame_panels.js";
import { Latest, frameSize, retryDelay } from "../../web/frames.js";
import { messageOf, subjectText } from "../../web/messages.js";

const bytesOf = (text) => new TextEncoder().encode(text);

test("Server-Timing is parsed with and without descriptions", () =>
  assert.deepEqual(parseServerTiming('queue;dur=0.1, surface;desc="a, b";dur=41.5, odd'),
                   [{ name: "queue", milliseconds: 0.1 }, { name: "surface", milliseconds: 41.5 }]));

test("a frame is requested again when its light has changed, also where another renderer has begun again", () => {
  const shown = lightOf("revision=2, share=0.50");
  assert.deepEqual(shown, { revision: 2, share: 0.5, failed: false });
  assert.deepEqual(lightOf("revision=2, share=0.50, failed"), { revision: 2, share: 0.5, failed: true });
  for (const [now, changed] of [[{ revision: 2, share: 0.6 }, false], [{ revision: 3, share: 0.7 }, true], [{ revision: 2, share: 1 }, true],
                                [{ revision: 0, share: 0 }, true], [undefined, true]]) {
    assert.equal(lightChanged(shown, now), changed, JSON.stringify(now));
  }
});

test("parts of a multipart response are complete, even if one contains the boundary", () => {
  const body = "--cut\r\nContent-Type: a/b\r\nContent-Length: 9\r\n\r\nx\r\n--cut!\r\n--cut\r\n" +
    'Content-Length: 2\r\nContent-Disposition: attachment; name="mirror:floor"\r\n\r\n{}\r\n--cut--\r\n';
  const parts = partsOf("multipart/mixed; boundary=cut", bytesOf(body));
  assert.deepEqual(parts.map((p) => new TextDecoder().decode(p.bytes)), ["x\r\n--cut!", "{}"]);
  assert.equal(parts[0].headers["content-type"], "a/b");
  assert.throws(() => partsOf("image/jpeg", bytesOf(body)));
});

test("a float32 NumPy file is read, and other types are rejected", () => {
  const file = (type) => {
    const head = `{'descr': '${type}', 'fortran_order': False, 'shape': (1, 1, 1), }`.padEnd(117) + "\n";
    const bytes = new Uint8Array(10 + head.length + 4);
    bytes.set([0x93, ...bytesOf("NUMPY"), 1, 0, head.length, 0, ...bytesOf(head)]);
    new DataView(bytes.buffer).setFloat32(10 + head.length, 7.25, true);
    return bytes.buffer;
  };
  assert.deepEqual(floatsOf(file("<f4")), [7.25]);
  assert.throws(() => floatsOf(file("<f8")));
  assert.throws(() => floatsOf(new ArrayBuffer(16)));
});

test("a path of the server is relative to the page", () => assert.equal(relativePath("/v1/jobs/1"), "v1/jobs/1"));

// ---- the plan ---------------------------------------------------------------------------------

const ball = { kind: "probe", name: "ball" }, floor = { kind: "mirror", name: "floor" };
const face = { kind: "capture", name: "probe:ball", subject: ball, effect: "environmentReflection", generation: 1, width: 128, height: 128,
               draws: 10, triangles: 100, reason: "no cube is resident", milliseconds: 2 };
const plan = {
  passes: [face, face, { ...face, kind: "levels", name: "probe:ball:levels", draws: 0, milliseconds: 0.5 },
           { kind: "surface", name: "surface", subject: null, effect: "base", width: 640, height: 360, draws: 5, triangles: 9, reason: "the view" }],
  skipped: [{ name: "mirror:floor", subject: floor, effect: "planarReflection", reason: "behind" }, { name: "mirror:floor", subject: floor, effect: "planarReflection", reason: "behind" }],
  decisions: [1, 2].map((n) => ({ name: "mirror:window", subject: { kind: "mirror", name: "window" }, effect: "planarReflection", taken: "traced", reason: `${n} %`,
    candidates: [{ method: "environment", milliseconds: 0, error: 0.8 }, { method: "traced", milliseconds: 3, error: 0.1 }] })),
};

test("the passes of one object are one row with their total time", () => {
  const rows = planRows(plan);
  assert.deepEqual(rows.map((r) => [r.title, r.milliseconds, r.draws]), [["Ball", 4.5, 20], ["Surfaces", undefined, 5]]);
  assert.deepEqual(rows[0].kinds, [{ text: "cube faces", count: 2 }, { text: "mip levels", count: 1 }]);
});

test("equal decisions and equal skipped passes are one row with a reason", () => {
  const [row, ...others] = decisionRows(plan);
  assert.deepEqual([row.title, row.taken, row.times, row.candidates[1].taken, others.length], ["Window", "ray traced", 2, true, 0]);
  assert.deepEqual(skippedRows(plan), [{ title: "Floor", effect: "Planar reflection", reason: "behind", times: 2 }]);
});

test("the title of a row is the name of the subject as it is, or of the pass if it has none", () => {
  assert.equal(subjectText({ kind: "probe", name: "brassFigure" }, "pass"), "Brass figure");
  assert.equal(subjectText({ kind: "mirror", name: "door:levels" }, "pass"), "Door:levels");
  assert.equal(subjectText(null, "toneMap"), "Tone map");
  const filter = (index) => ({ kind: "glow", name: `filter${index}:glow`, subject: { kind: "filter", name: "glow", index },
                               effect: "filters", draws: 0, triangles: 0, reason: "" });
  assert.deepEqual(planRows({ passes: [filter(0), filter(0), filter(1)] }).map((r) => [r.title, r.kinds[0].count]), [["Glow", 2], ["Glow", 1]]);
});

test("the parts of the time of a frame add up to the total", () => {
  const { total, parts } = timeParts([1, 2, 3, 4, 5, 6, 7].map((ms) => ({ name: `p${ms}`, milliseconds: ms }))
    .concat({ name: "total", milliseconds: 30 }));
  assert.equal(total, 30);
  assert.equal(parts.reduce((sum, p) => sum + p.milliseconds, 0), 30);
  assert.deepEqual([parts[0].name, parts.at(-1)], ["p7", { name: "rest", milliseconds: 5 }]);
});

// ---- problems ---------------------------------------------------------------------------------

test("requests are retried if the server is busy, stopping or unreachable, not if they are invalid", () => {
  const message = (status, code = "") => messageOf({ status, code, title: "", detail: "why" });
  assert.match(message(503, "queueFull").title, /busy/);
  assert.match(message(503, "shuttingDown").title, /shutting down/);
  for (const status of [0, 409, 429, 502, 503]) assert.equal(message(status).retry, true, status);
  for (const status of [400, 403, 404, 422, 500, 504]) assert.equal(message(status).retry, false, status);
  const refused = messageOf({ status: 422, title: "", errors: [{ pointer: "/width", detail: "is out of range", allowed: "1 to 4096" }] });
  assert.deepEqual(refused.lines, ["/width is out of range (allowed: 1 to 4096)"]);
});

test("the retry delay is that of the server, or grows with every failure", () => {
  assert.equal(retryDelay(3, 5), 3);
  assert.deepEqual([1, 2, 3, 9].map((n) => retryDelay(undefined, n)), [1, 2, 4, 10]);
});

// ---- pace -------------------------------------------------------------------------------------

test("of the requests that arrive during another only the newest runs", async () => {
  const ran = [];
  let release;
  const gate = new Promise((resolve) => { release = resolve; });
  const latest = new Latest(async (wanted) => {
    ran.push(wanted);
    if (wanted === 1) await gate;
  });
  for (const wanted of [1, 2, 3, 4]) latest.request(wanted);
  release();
  await new Promise((resolve) => setTimeout(resolve));
  assert.deepEqual(ran, [1, 4]);
});

test("a frame keeps its aspect ratio within the limits", () => {
  assert.deepEqual(frameSize(100, 50, 2, { maxPixels: 1e6, maxEdge: 4096 }), [200, 100]);
  const [width, height] = frameSize(4000, 2000, 2, { maxPixels: 1280 * 720, maxEdge: 4096 });
  assert.ok(width * height <= 1280 * 720 && Math.abs(width / height - 2) < 0.01);
});

// ---- the chart --------------------------------------------------------------------------------

test("the hull is the lower left convex hull", () => {
  const at = (label, milliseconds, error) => ({ label, milliseconds, error });
  const hull = hullOf([at("fine", 100, 0.01), at("worse", 120, 0.02), at("dull", 10, 0.9), at("draft", 1, 1),
                       at("standard", 10, 0.05), at("broken", 0, 0)]);
  assert.deepEqual(hull.map((p) => p.label), ["draft", "standard", "fine"]);
});

test("ticks are few round numbers on the axis", () => {
  assert.deepEqual(logTicks(40, 600), [50, 100, 200, 500]);
  for (const [low, high] of [[1e-4, 1e4], [0.9, 1.2], [3, 1e6]]) {
    const ticks = logTicks(low, high);
    assert.ok(ticks.length <= 6 && ticks.every((t) => t >= low && t <= high), `${ticks}`);
  }
  const axis = logAxis([10, 1000], 200);
  assert.ok(axis.at(10) > 0 && axis.at(1000) < 200 && Math.abs(axis.at(100) - 100) < 1e-9);
  assert.deepEqual([shortNumber(2000), shortNumber(0.0123)], ["2k", "0.012"]);
});

test("a sweep varies each setting separately, within its range and the maximum number of settings", () => {
  const schemas = {
    planar: { type: "string", enum: ["automatic", "mirror", "traced"] }, backFaces: { type: "boolean" },
    generations: { type: "integer", minimum: 1, maximum: 8 }, maxError: { type: "number", minimum: 1e-6, maximum: 1000 },
  };
  const common = { presets: ["draft", "fine"], schemas, values: { planar: "automatic", backFaces: false, generations: 1 } };
  const plain = settingsFor({ ...common, current: { preset: "draft" }, sweep: false });
  assert.deepEqual(plain.map((s) => s.label), ["draft", "fine"]);
  const swept = settingsFor({ ...common, current: { preset: "draft", bounces: 2 }, sweep: true });
  assert.deepEqual(swept.map((s) => s.label), ["draft", "fine", "current setting", "planar mirror", "planar traced", "backFaces true", "generations 2"]);
  assert.deepEqual(swept[3].accuracy, { preset: "draft", bounces: 2, planar: "mirror" });
  assert.equal(settingsFor({ ...common, current: {}, sweep: true, maxSettings: 4 }).length, 4);
});
