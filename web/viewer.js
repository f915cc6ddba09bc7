// The page: state, wishes for frames, and what the answers say. Mathematics and HTTP are in the
// modules beside it.
import { Problem, curlOf, decisionText, getJson, planOf, queryOf, renderFrame, rounded } from "./api.js";
import { fromDirection, fromLookAt, lensFor, orbit, pan, positionOf, walk, zoom } from "./camera.js";
import { controlsFor, element, fillSelect } from "./controls.js";
import { gestureOf, wheelZoom } from "./gestures.js";
import { Latest, frameSize, movingPixels } from "./pace.js";

const $ = (id) => document.getElementById(id);
const kMovingMs = 90;       // what a frame may take while the camera moves
const kRestMs = 160;        // stillness after which the full frame is asked for
const kLeastPixels = 160 * 90;
const calm = matchMedia("(prefers-reduced-motion: reduce)");

const state = {
  scene: undefined,   // GET v1/scenes/{id}
  camera: undefined,  // see camera.js
  start: undefined,   // where "Back to start" goes
  values: { effects: {}, picture: {}, knobs: {}, preset: undefined, environment: "" },
  limits: { maxPixels: 1280 * 720, maxEdge: 4096 },
  moving: 320 * 180,  // pixels of a frame while moving
};

// ---- frames ---------------------------------------------------------------------------------

function requestFor(pixels) {
  const box = $("stage").getBoundingClientRect();
  const ratio = Math.min(2, devicePixelRatio || 1);
  const [width, height] = frameSize(box.width, box.height, ratio, { ...state.limits, maxPixels: pixels });
  const { values, camera } = state;
  return rounded({
    scene: state.scene.id,
    camera: { position: positionOf(camera), target: camera.target, yfov: lensFor(camera.yfov, box.width / box.height) },
    width,
    height,
    effects: values.effects,
    accuracy: { preset: values.preset, ...values.knobs },
    ...(values.environment ? { environment: { map: values.environment } } : {}),
    ...values.picture,
  });
}

let shownUrl;
async function show(blob) {
  const url = URL.createObjectURL(blob);
  $("frame").src = url;
  await $("frame").decode().catch(() => {});
  if (shownUrl) URL.revokeObjectURL(shownUrl);
  shownUrl = url;
}

const frames = new Latest(async ({ still }) => {
  if (!state.camera) return;
  const request = requestFor(still ? state.limits.maxPixels : state.moving);
  try {
    const answer = await renderFrame(request);
    await show(answer.blob);
    const pixels = request.width * request.height;
    if (!still) {
      state.moving = movingPixels({ pixels, milliseconds: answer.milliseconds }, kMovingMs,
                                  { least: kLeastPixels, most: state.limits.maxPixels });
    }
    say("");
    report(answer, request, still);
    if (still) reportDecisions(await planOf(request));
  } catch (problem) {
    if (!(problem instanceof Problem)) throw problem;
    sayProblem(problem);
    if (problem.retryAfterSeconds) setTimeout(() => frames.ask({ still: true }), 1000 * problem.retryAfterSeconds);
  }
});

let rest;
function moved() {
  clearTimeout(rest);
  rest = setTimeout(() => frames.ask({ still: true }), kRestMs);
  frames.ask({ still: calm.matches });
}
const changed = () => frames.ask({ still: true });

// ---- words ----------------------------------------------------------------------------------

function say(text, bad = false) {
  $("note").hidden = !text;
  $("note").textContent = text;
  $("note").classList.toggle("bad", bad);
}

function sayProblem({ title, detail, errors, status }) {
  const lines = errors.map((e) => `${e.pointer}: ${e.detail}${e.allowed ? ` (allowed: ${e.allowed})` : ""}`);
  say([status ? `${title} (${status})` : title, ...(lines.length ? lines : [detail])].join("\n"), true);
}

function report({ timings, passes, milliseconds }, { width, height }, still) {
  $("caption").textContent = `${width} x ${height}${still ? "" : ", moving"} in ${milliseconds.toFixed(0)} ms`;
  $("passes").textContent = passes.length ? `Passes: ${passes.join(", ")}` : "";
  const total = timings.find((t) => t.name === "total")?.milliseconds || 1;
  $("timings").tBodies[0].replaceChildren(...timings.map(({ name, milliseconds: ms }) =>
    element("tr", {},
      element("td", {}, name),
      element("td", {}, element("meter", { min: 0, max: total, value: ms, title: `${ms} of ${total} ms` })),
      element("td", {}, `${ms.toFixed(1)} ms`))));
}

function reportDecisions({ decisions }) {
  $("decisions").replaceChildren(...decisions.map((d) => {
    const others = d.candidates.map((c) => `${c.method}: ${c.milliseconds.toFixed(1)} ms, error ${c.error.toFixed(2)}`);
    return element("li", { title: others.join("\n") }, decisionText(d));
  }));
}

async function copy(text, what) {
  try {
    await navigator.clipboard.writeText(text);
    say(`Copied the ${what}.`);
  } catch {
    say(text);
  }
}

// ---- scenes ---------------------------------------------------------------------------------

function goTo(view) {
  state.camera = fromLookAt(view);
  state.start = state.camera;
  changed();
}

function chooseCamera(name) {
  const { defaultView, cameras } = state.scene;
  const camera = cameras.find((c) => c.name === name);
  if (!camera) return goTo(defaultView);
  const distance = Math.hypot(...camera.position.map((x, i) => x - defaultView.target[i])) || 1;
  state.camera = fromDirection({ position: camera.position, direction: camera.direction, distance, yfov: camera.yfov });
  state.start = state.camera;
  changed();
}

async function chooseScene(id) {
  try {
    const scene = await getJson(`v1/scenes/${encodeURIComponent(id)}`);
    if (scene.state !== "ready") {
      const percent = Math.round(100 * (scene.progress ?? 0));
      say(scene.state === "failed" ? `${id} could not be loaded: ${scene.failure ?? ""}` : `Loading ${id}: ${scene.stage ?? ""} ${percent} %`, scene.state === "failed");
      if (scene.state !== "failed") {
        frames.ask({ still: true });  // the first frame makes a waiting scene load
        setTimeout(() => $("scene").value === id && chooseScene(id), 400);
      }
      return;
    }
    state.scene = { cameras: [], ...scene };
    const usable = state.scene.cameras.filter((c) => c.position && c.direction && c.yfov);
    fillSelect($("camera"), [["", "default view"], ...usable.map((c) => [c.name, c.name])], "");
    chooseCamera("");
  } catch (problem) {
    if (!(problem instanceof Problem)) throw problem;
    sayProblem(problem);
    if (problem.status === 409) setTimeout(() => $("scene").value === id && chooseScene(id), 600);
  }
}

// ---- hands ----------------------------------------------------------------------------------

function listen() {
  const stage = $("stage");
  const points = new Map();
  const side = () => Math.min(stage.clientWidth, stage.clientHeight);
  stage.addEventListener("pointerdown", (e) => {
    stage.setPointerCapture(e.pointerId);
    points.set(e.pointerId, [e.clientX, e.clientY]);
  });
  stage.addEventListener("pointermove", (e) => {
    if (!points.has(e.pointerId) || !state.camera) return;
    const before = [...points.values()].slice(0, 2);
    points.set(e.pointerId, [e.clientX, e.clientY]);
    const g = gestureOf(before, [...points.values()].slice(0, 2), side(), e.shiftKey || (e.buttons & 6) !== 0);
    state.camera = g.kind === "orbit" ? orbit(state.camera, g.dx, g.dy) : zoom(pan(state.camera, g.dx, g.dy), g.zoom);
    moved();
  });
  for (const end of ["pointerup", "pointercancel"]) stage.addEventListener(end, (e) => points.delete(e.pointerId));
  stage.addEventListener("contextmenu", (e) => e.preventDefault());
  stage.addEventListener("wheel", (e) => {
    e.preventDefault();
    if (!state.camera) return;
    state.camera = zoom(state.camera, wheelZoom(e.deltaY, e.deltaMode));
    moved();
  }, { passive: false });

  const turn = 0.06;
  const keys = {
    ArrowLeft: (c) => orbit(c, turn, 0), ArrowRight: (c) => orbit(c, -turn, 0),
    ArrowUp: (c) => orbit(c, 0, turn), ArrowDown: (c) => orbit(c, 0, -turn),
    "+": (c) => zoom(c, 1 / 1.1), "=": (c) => zoom(c, 1 / 1.1), "-": (c) => zoom(c, 1.1),
    w: (c) => walk(c, c.distance / 20, 0, 0), s: (c) => walk(c, -c.distance / 20, 0, 0),
    a: (c) => walk(c, 0, -c.distance / 20, 0), d: (c) => walk(c, 0, c.distance / 20, 0),
    e: (c) => walk(c, 0, 0, c.distance / 20), q: (c) => walk(c, 0, 0, -c.distance / 20),
    r: () => state.start,
  };
  stage.addEventListener("keydown", (e) => {
    const action = keys[e.key] ?? keys[e.key.toLowerCase()];
    if (!action || e.ctrlKey || e.metaKey || e.altKey || !state.camera) return;
    e.preventDefault();
    state.camera = action(state.camera);
    moved();
  });
  new ResizeObserver(() => state.camera && moved()).observe(stage);
}

// ---- start ----------------------------------------------------------------------------------

async function start() {
  listen();
  const [schema, renderer, { scenes }] = await Promise.all(
    [getJson("openapi.json"), getJson("v1/renderer"), getJson("v1/scenes")]);
  const fields = schema.components.schemas.FrameRequest.properties;
  $("renderer").textContent = `${renderer.renderer}${renderer.software ? ", software" : ""}`;
  state.limits = { maxPixels: Math.min(renderer.limits.pixels, renderer.software ? 1280 * 720 : 2560 * 1440), maxEdge: renderer.limits.edge };

  const { values } = state;
  for (const [name, field] of Object.entries(fields.effects.properties)) values.effects[name] = field.default;
  controlsFor($("effects"), fields.effects.properties, values.effects, changed);
  controlsFor($("picture"), { toneMap: fields.toneMap, exposure: fields.exposure }, values.picture, changed);
  const { preset, ...knobs } = fields.accuracy.oneOf[1].properties;
  values.preset = fields.accuracy.default;
  fillSelect($("preset"), preset.enum.map((word) => [word, word]), values.preset);
  controlsFor($("knobs"), knobs, values.knobs, changed, { optional: true });
  fillSelect($("environment"), [["", "the scene's own"], ...renderer.environments.map((e) => [e, e])], "");
  fillSelect($("scene"), scenes.map((s) => [s.id, s.title || s.id]), (scenes.find((s) => s.default) ?? scenes[0]).id);

  $("scene").addEventListener("change", () => chooseScene($("scene").value));
  $("camera").addEventListener("change", () => chooseCamera($("camera").value));
  $("environment").addEventListener("change", () => {
    values.environment = $("environment").value;
    changed();
  });
  $("preset").addEventListener("change", () => {
    values.preset = $("preset").value;
    changed();
  });
  $("reset").addEventListener("click", () => {
    state.camera = state.start;
    changed();
  });
  const full = () => requestFor(state.limits.maxPixels);
  $("curl").addEventListener("click", () => copy(curlOf(full(), location.origin), "command"));
  $("link").addEventListener("click", () => copy(`${location.origin}/v1/frames?${queryOf(full())}`, "link"));
  await chooseScene($("scene").value);
}

start().catch((problem) => (problem instanceof Problem ? sayProblem(problem) : say(String(problem), true)));
