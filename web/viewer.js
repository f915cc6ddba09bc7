// The page put together: the session, the hands on the picture, frames, panels, and the words about them.
import { Problem, getJson, pixelOf, putView, renderFrame, uploadScene, useToken } from "./api.js";
import { focusOn, lensFor, lensOfPixel, pointAt, positionOf } from "./camera.js";
import { ComparePanel } from "./compare_panel.js";
import { controlFor, controlsFor } from "./controls.js";
import { showCost } from "./cost_panel.js";
import { $, fillSelect, segments, showBlob, tabs } from "./dom.js";
import { filtersPart } from "./filters_part.js";
import { Frames } from "./frames.js";
import { Hands, flyPad } from "./hands.js";
import { showMaps } from "./maps_panel.js";
import * as note from "./note.js";
import { resolved, wordsOf } from "./schema.js";
import { Session } from "./session.js";
import { share } from "./share.js";
import { TimeRow } from "./time_row.js";
import { Wipe, wipeChoices } from "./wipe.js";
import { millisecondsWords, problemWords, sizeWords } from "./words.js";

const reduced = matchMedia("(prefers-reduced-motion: reduce)");
const calm = () => reduced.matches;
let session, frames, hands, wipe, compare, time, shared;
let drawnScene;  // id of the scene that the last frame showed

// ---- frames ---------------------------------------------------------------------------------

async function shown(answer, request, still) {
  await showBlob($("frame"), answer.blob);
  drawnScene = request.scene;
  note.clear();
  const { width, height } = request;
  $("caption").textContent = `${width} × ${height} · ${millisecondsWords(answer.milliseconds)}`;
  $("stage").classList.toggle("moving", !still);
  compare.viewIs(frameRequest([width, height]));
  if (!still) return;
  showCost(answer, request);
  if (wipe.on) await wipe.showRight(frameRequest([width, height]), renderFrame);
  if (shared.live()) await putView(shared.live(), request);
  history.replaceState(null, "", `#${session.query()}`);
}

const frameRequest = (size, options) => (session.camera ? session.request(size, options) : undefined);
const changed = () => frames.changed();
function moved() {
  wipe.hide();
  frames.moved();
}

// ---- scenes ---------------------------------------------------------------------------------

const later = (seconds) => new Promise((resolve) => setTimeout(resolve, 1000 * seconds));

// Waits until the scene is there, and tells how far it is. A scene that waits begins to load when a
// frame of it is asked for. Given up once nobody wants it any more.
async function loadedScene(id, wanted = () => $("scene").value === id) {
  for (let failures = 0; wanted();) {
    try {
      const scene = await getJson(`v1/scenes/${encodeURIComponent(id)}`);
      failures = 0;
      if (scene.state === "ready") return scene;
      if (scene.state === "failed") {
        note.sayProblem(new Problem({ status: 422, title: "", errors: [{ pointer: id, detail: `could not be loaded: ${scene.failure ?? ""}` }] }));
        return undefined;
      }
      note.sayProgress(`Loading ${id}`, scene.stage ?? "", scene.progress);
      if (scene.state === "waiting") await renderFrame({ scene: id, width: 1, height: 1 });
    } catch (problem) {
      if (!(problem instanceof Problem)) throw problem;
      if (problem.status !== 409) {
        if (!problemWords(problem).waits) {
          note.sayProblem(problem);
          return undefined;
        }
        const seconds = problem.retryAfterSeconds ?? Math.min(10, 2 ** failures++);
        note.sayProblem(problem, seconds);
        await later(seconds);
      }
    }
    await later(0.3);
  }
  return undefined;
}

// Until the first frame of the scene is there: how many of its shaders are compiled.
async function showCompilation(id) {
  for (await later(1); drawnScene !== id && $("scene").value === id; await later(0.5)) {
    try {
      const { shaders } = await getJson(`v1/scenes/${encodeURIComponent(id)}`);
      if (!shaders || shaders.finished) return;
      if (drawnScene === id || shaders.total === 0) continue;
      note.sayProgress(`Compiling shaders for ${id}`, `${shaders.compiled} of ${shaders.total} programs`,
        shaders.compiled / shaders.total);
    } catch (problem) {
      if (!(problem instanceof Problem)) throw problem;
      return;
    }
  }
}

// Whether it is what the page shows now.
async function chooseScene(id, view) {
  const scene = await loadedScene(id);
  if (!scene || $("scene").value !== id) return false;
  note.clear();
  session.scene = scene;
  const cameras = (scene.cameras ?? []).filter((c) => c.position && c.direction && c.yfov);
  fillSelect($("camera"), [["", "default view"], ...cameras.map((c) => [c.name, c.name])], "");
  $("camera-pick").hidden = cameras.length === 0;
  session.useCamera("");
  if (view) {
    const { start } = session;
    session.goTo(view);
    session.start = start;
  }
  time.sceneChanged();
  changed();
  showCompilation(id);
  return true;
}

async function focus(x, y) {
  const { clientWidth: width, clientHeight: height } = $("stage");
  const { camera, scene } = session;
  const lens = lensOfPixel(lensFor(camera.yfov, width / height), width, height, x, y);
  const at = { scene: scene.id, camera: { position: positionOf(camera), target: camera.target }, time: session.time };
  try {
    const depth = await pixelOf(at, lens, "depth");
    if (!(depth > 0)) return note.say("", "There is nothing there to focus on.");
    hands.glideTo(focusOn(camera, pointAt(camera, lens, depth)));
  } catch (problem) {
    if (!(problem instanceof Problem)) throw problem;
    note.sayProblem(problem);
  }
}

// ---- panels ---------------------------------------------------------------------------------

function drawKnobs() {
  segments($("preset"), "preset", session.presets, session.preset, (word) => {
    session.preset = word;
    drawKnobs();
    changed();
  });
  $("knobs").replaceChildren(...Object.entries(session.knobSchemas).flatMap(([name, schema]) => {
    const row = controlFor(name, schema, session.knobValue(name), (value) => {
      if (value === undefined) delete session.knobs[name];
      else session.knobs[name] = value;
      row.classList.toggle("set", name in session.knobs);
      $("knobs-reset").hidden = Object.keys(session.knobs).length === 0;
      changed();
    }, { none: session.knobValue(name) === undefined ? "none" : undefined });
    row?.classList.toggle("set", name in session.knobs);
    return row ?? [];
  }));
  $("knobs-reset").hidden = Object.keys(session.knobs).length === 0;
}

function drawView(environments) {
  const { properties } = session.schema;
  controlsFor($("effects"), properties.effects.properties, session.effects, changed);
  const { rotation, ...light } = properties.environment.properties;
  controlsFor($("light"), { ...light, map: { ...light.map, enum: environments } }, session.environment, changed,
              { map: "the scene's own" });
  const heading = { type: "number", minimum: -180, maximum: 180, description: "turns the environment map about the vertical, degrees" };
  if (rotation) {
    $("light").append(controlFor("heading", heading, session.headingDegrees, (value) => {
      session.headingDegrees = value ?? 0;
      changed();
    }));
  }
  controlsFor($("picture"), session.pictureSchemas, session.picture, changed);
}

// A file of the visitor's becomes a scene; where it does not, the old one stays.
async function sendScene(file, most) {
  const before = $("scene").value;
  try {
    if (file.size > most) {
      throw new Problem({ status: 413, title: "Too large", detail: `${file.name} has ${sizeWords(file.size)}; the server takes ${sizeWords(most)}.` });
    }
    const id = await uploadScene(file, (share) => note.sayProgress(`Sending ${file.name}`, "", share));
    const stays = () => $("scene").value === before;
    const scene = await loadedScene(id, stays);  // not chosen before: one that fails is not in the list
    if (scene || !stays()) await listScenes(stays() ? id : $("scene").value);
    if ($("scene").value === id) await chooseScene(id);
  } catch (problem) {
    if (!(problem instanceof Problem)) throw problem;
    note.sayProblem(problem);
  }
}

function listenToUpload(most) {
  if (!(most > 0)) return;
  $("upload-pick").hidden = false;
  $("upload").addEventListener("change", async () => {
    const [file] = $("upload").files;
    if (file) await sendScene(file, most);
    $("upload").value = "";  // so that the same file may be chosen again
  });
}

async function listScenes(chosen) {
  const { scenes } = await getJson("v1/scenes");
  const first = scenes.find((s) => s.id === chosen) ?? scenes.find((s) => s.default) ?? scenes[0];
  fillSelect($("scene"), scenes.map((s) => [s.id, s.title || s.id]), first.id);
}

function listenToBar() {
  const reset = () => hands.glideTo(session.start);
  $("reset").addEventListener("click", reset);
  for (const radio of document.querySelectorAll("input[name=mode]")) {
    radio.addEventListener("change", () => {
      hands.mode = radio.value;
      $("pad").hidden = radio.value !== "fly";
    });
  }
  $("help").addEventListener("click", () => {
    $("keys").hidden = !$("keys").hidden;
    $("help").setAttribute("aria-expanded", !$("keys").hidden);
  });
  $("full-screen").hidden = !document.fullscreenEnabled;
  $("full-screen").addEventListener("click", () =>
    (document.fullscreenElement ? document.exitFullscreen() : $("left").requestFullscreen()).catch(() => {}));
  hands = new Hands({ stage: $("stage"), session, moved, calm, focus, reset, play: () => time.toggle() });
  flyPad($("pad"), hands);
  new ResizeObserver(() => session.camera && moved()).observe($("stage"));
}

// ---- start ----------------------------------------------------------------------------------

async function start() {
  const [schema, renderer] = await Promise.all([getJson("openapi.json"), getJson("v1/renderer")]);
  $("renderer").textContent = `${renderer.renderer}${renderer.software ? ", software" : ""}`;
  session = new Session(resolved(schema.components.schemas.FrameRequest, schema));
  const asked = session.read(location.hash);
  const limits = { maxPixels: Math.min(renderer.limits.pixels, renderer.software ? 1280 * 720 : 2560 * 1440), maxEdge: renderer.limits.edge };
  const box = () => ({ width: $("stage").clientWidth, height: $("stage").clientHeight, ratio: Math.min(2, devicePixelRatio || 1) });
  frames = new Frames({ limits, box, calm, shown, failed: note.sayProblem, requestFor: (size, options) => {
    const request = frameRequest(size, options);
    return request && wipe.left(request);
  } });
  time = new TimeRow(session, moved);
  wipe = new Wipe(wipeChoices(session.presets, Object.keys(session.effects), wordsOf), changed);
  compare = new ComparePanel({ session, request: frameRequest, use: (accuracy) => {
    const { preset, ...knobs } = typeof accuracy === "string" ? { preset: accuracy } : accuracy;
    Object.assign(session, { preset, knobs });
    drawKnobs();
    changed();
  }, truth: (path) => wipe.setTruth(path), size: (width) => {
    const [w, h] = frames.size();
    return [width, Math.max(1, Math.round((width * h) / w))];
  } });
  drawView(renderer.environments);
  drawKnobs();
  const { filters } = session.schema.properties;
  if (filters) filtersPart(session, filters, changed);
  $("knobs-reset").addEventListener("click", () => {
    session.knobs = {};
    drawKnobs();
    changed();
  });
  tabs(document.querySelector("[role=tablist]"), () => { $("hint").textContent = ""; });
  listenToBar();
  shared = share({ session, changed, paths: schema.paths, full: () => frameRequest(frames.size()) });
  listenToUpload(renderer.limits.uploadBytes);
  $("maps-show").addEventListener("click", () => showMaps(frameRequest(frames.size())));
  $("scene").addEventListener("change", () => chooseScene($("scene").value));
  $("camera").addEventListener("change", () => {
    session.useCamera($("camera").value);
    changed();
  });
  addEventListener("hashchange", () => location.reload());
  await listScenes(asked.scene);
  await chooseScene($("scene").value, asked.view);
}

// The token lives as long as the tab.
function askForToken() {
  note.clear();
  $("token-form").hidden = false;
  $("token").value = "";
  $("token").focus();
}
$("token-form").addEventListener("submit", (e) => {
  e.preventDefault();
  sessionStorage.setItem("token", $("token").value);
  useToken($("token").value);
  $("token-form").hidden = true;
  begin();
});

// A server that is away while the page opens is asked again like any other.
async function begin(failures = 1) {
  try {
    await start();
  } catch (problem) {
    if (!(problem instanceof Problem)) throw problem;
    if (problem.status === 401 && !session) return askForToken();
    const seconds = problemWords(problem).waits && !session ? problem.retryAfterSeconds ?? Math.min(10, 2 ** (failures - 1)) : undefined;
    note.sayProblem(problem, seconds);
    if (seconds !== undefined) setTimeout(() => begin(failures + 1), 1000 * seconds);
  }
}
useToken(sessionStorage.getItem("token") ?? "");
begin();
