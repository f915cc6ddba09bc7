// Connects the parts of the page: session, input, frames, panels and messages.
import { Problem, getJson, lightChanged, pixelOf, putView, renderFrame, useToken } from "./api.js";
import { backgroundControls } from "./background_part.js";
import { focusOn, lensFor, lensOfPixel, pointAt, positionOf } from "./camera.js";
import { ComparePanel } from "./compare_panel.js";
import { connectTips, controlFor, controlsFor, filterControls, tipSegments } from "./controls.js";
import { $, fillSelect, segments, showBlob, tabs } from "./dom.js";
import { showCost, showMaps } from "./frame_panels.js";
import { Frames, retryDelay } from "./frames.js";
import { groundControls } from "./ground_part.js";
import { InputHandler, connectFlightButtons } from "./input.js";
import { sceneIdOf } from "./joined.js";
import { LightRows } from "./light_rows.js";
import { connectSharing } from "./links.js";
import { MapChoice } from "./map_choice.js";
import { clearMessage, messageOf, millisecondsText, showMessage, showProblem } from "./messages.js";
import { ObjectRows } from "./object_rows.js";
import { PartRows } from "./part_rows.js";
import { connectPicture } from "./picture.js";
import { SceneChoice } from "./scene_choice.js";
import { labelOf, resolved } from "./schema.js";
import { Session } from "./session.js";
import { TimeRow } from "./time_row.js";
import { Turntable } from "./turntable.js";
import { Uploads } from "./upload.js";
import { VariantRow } from "./variant_row.js";
import { Wipe, wipeChoices } from "./wipe.js";

const motion = matchMedia("(prefers-reduced-motion: reduce)");
const reducedMotion = () => motion.matches;
let session, frames, input, wipe, compare, time, variants, lights, objects, parts, turntable, sharing, choice;
let lightTimer;  // of the next look at the progress of its light
const kLightPollMs = 1000, kJoinedPollMs = 4000;

// ---- frames ---------------------------------------------------------------------------------

const lightText = ({ share, failed }) => (failed ? "failed" : `${Math.round(100 * share)} %`);

async function shown(frame, request, still, signal) {
  await showBlob($("frame"), frame.blob);
  if (signal.aborted) return;  // another scene was chosen meanwhile
  choice.shown(request, still);
  clearMessage();
  const { width, height } = request;
  const light = frame.light && frame.light.share < 1 ? ` · light ${lightText(frame.light)}` : "";
  $("caption").textContent = `${width} × ${height} · ${millisecondsText(frame.milliseconds)}${light}`;
  $("stage").classList.toggle("moving", !still);
  compare.viewChanged(frameRequest([width, height]));
  clearTimeout(lightTimer);
  if (!still) return;
  if (light && !frame.light.failed) followLight(frame.light, request.scene);
  showCost(frame, request);
  if (wipe.on) await wipe.showRight(frameRequest([width, height]), (right) => renderFrame(right, "0", signal));
  if (sharing.live()) await putView(sharing.live(), request);
  history.replaceState(null, "", `#${session.query()}`);
}

// Requests the frame again when its light has changed. Only frames tell that of joined scenes.
function followLight(shown, scene) {
  const id = sceneIdOf(scene);
  lightTimer = setTimeout(async () => {
    if (Array.isArray(scene)) return frames.refresh();
    try {
      const { light } = await getJson(`v1/scenes/${encodeURIComponent(id)}`);
      if (lightChanged(shown, light)) return frames.refresh();
    } catch (problem) {
      if (!(problem instanceof Problem)) throw problem;
    }
    if (choice.shownId === id && !choice.opening) followLight(shown, scene);
  }, Array.isArray(scene) ? kJoinedPollMs : kLightPollMs);
}

function failed(problem, seconds) {
  choice.failed();
  showProblem(problem, seconds);
}

const frameRequest = (size, options) => (session.camera ? session.request(size, options) : undefined);
const changed = () => frames.changed();
function moved() {
  wipe.hide();
  frames.moved();
}

// Buttons that need a view are disabled until there is one; after that each has its own state.
function enableViewButtons() {
  for (const button of document.querySelectorAll("[data-needs-view]")) {
    button.disabled = false;
    delete button.dataset.needsView;
  }
}

// The session has another scene. view: instead of the default one.
function opened(view) {
  clearTimeout(lightTimer);
  wipe.hide();
  turntable.stop();
  const cameras = (session.scene.cameras ?? []).filter((c) => c.position && c.direction && c.yfov);
  fillSelect($("camera"), [["", "default view"], ...cameras.map((c) => [c.name, c.name])], "");
  $("camera-pick").hidden = cameras.length === 0;
  session.useCamera("");
  if (view) {
    const { start } = session;
    session.goTo(view);
    session.start = start;
  }
  session.keepOwn();
  enableViewButtons();
  time.sceneChanged();
  variants.sceneChanged();
  lights.sceneChanged();
  objects.sceneChanged();
  parts.sceneChanged();
}

async function focus(x, y) {
  const { clientWidth: width, clientHeight: height } = $("stage");
  const { camera } = session;
  if (!camera || choice.opening) return;
  const lens = lensOfPixel(lensFor(camera.yfov, width / height), width, height, x, y);
  const at = { scene: session.joined, camera: { position: positionOf(camera), target: camera.target }, time: session.time };
  try {
    const depth = await pixelOf(at, lens, "depth");
    if (!(depth > 0)) return showMessage("", "There is nothing to focus on at this point.");
    input.animateTo(focusOn(camera, pointAt(camera, lens, depth)));
  } catch (problem) {
    if (!(problem instanceof Problem)) throw problem;
    showProblem(problem);
  }
}

// ---- panels ---------------------------------------------------------------------------------

function drawAccuracy() {
  segments($("preset"), "preset", session.presets, session.preset, (word) => {
    session.preset = word;
    drawAccuracy();
    changed();
  });
  tipSegments($("preset"), "Determines every setting below that is not changed: draft is fast, fine is exact.");
  const { accuracySettings: settings } = session;
  const showReset = () => { $("accuracy-reset").hidden = Object.keys(settings).length === 0; };
  $("accuracy-settings").replaceChildren(...Object.entries(session.accuracySchemas).flatMap(([name, schema]) => {
    const row = controlFor(name, schema, session.accuracyValue(name), (value) => {
      if (value === undefined) delete settings[name];
      else settings[name] = value;
      row.classList.toggle("set", name in settings);
      showReset();
      changed();
    }, { none: session.accuracyValue(name) === undefined ? "none" : undefined });
    row?.classList.toggle("set", name in settings);
    return row ?? [];
  }));
  showReset();
}

function drawView() {
  const { properties } = session.schema;
  controlsFor($("effects"), properties.effects.properties, session.effects, changed);
  controlsFor($("image-settings"), session.imageSchemas, session.image, changed);
}

function listenToBar() {
  const reset = () => {
    turntable.stop();
    if (session.start) input.animateTo(session.start);
  };
  $("reset").addEventListener("click", reset);
  for (const radio of document.querySelectorAll("input[name=mode]")) {
    radio.addEventListener("change", () => {
      input.mode = radio.value;
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
  input = new InputHandler({ stage: $("stage"), session, moved, reducedMotion, focus, reset, play: () => time.toggle() });
  connectFlightButtons($("pad"), input);
  new ResizeObserver(() => session.camera && moved()).observe($("stage"));
}

// ---- start ----------------------------------------------------------------------------------

async function start() {
  const [schema, renderer, { environments }] = await Promise.all(["openapi.json", "v1/renderer", "v1/environments"].map(getJson));
  $("renderer").textContent = `${renderer.renderer}${renderer.software ? ", software" : ""}`;
  session = new Session(resolved(schema.components.schemas.FrameRequest, schema));
  const fromLink = session.read(location.hash);
  const limits = { maxPixels: Math.min(renderer.limits.pixels, renderer.software ? 1280 * 720 : 2560 * 1440), maxEdge: renderer.limits.edge };
  const box = () => ({ width: $("stage").clientWidth, height: $("stage").clientHeight, ratio: Math.min(2, devicePixelRatio || 1) });
  frames = new Frames({ limits, box, reducedMotion, presets: session.presets, shown, failed, requestFor: (size, options) => {
    const request = choice.opening ? undefined : frameRequest(size, options);
    return request && wipe.left(request);
  } });
  choice = new SceneChoice({ session, frames, opened, acceptsFiles: renderer.limits.uploadBytes > 0 });
  turntable = new Turntable({ session, moved, reducedMotion });
  lights = new LightRows(session, changed);
  objects = new ObjectRows({ session, request: frameRequest, size: () => frames.size(), changed, failed: showProblem });
  parts = new PartRows({ session, choice, changed: () => {
    objects.sceneChanged();
    changed();
  } });
  time = new TimeRow(session, moved);
  variants = new VariantRow(session, changed);
  wipe = new Wipe(wipeChoices(session.presets, Object.keys(session.effects), labelOf), changed);
  compare = new ComparePanel({ session, request: frameRequest, use: (accuracy) => {
    const { preset, ...accuracySettings } = typeof accuracy === "string" ? { preset: accuracy } : accuracy;
    Object.assign(session, { preset, accuracySettings });
    drawAccuracy();
    changed();
  }, reference: (path) => wipe.setReference(path), size: (width) => {
    const [w, h] = frames.size();
    return [width, Math.max(1, Math.round((width * h) / w))];
  } });
  const maps = new MapChoice(session, changed, environments);
  drawView();
  drawAccuracy();
  groundControls(session, changed);
  backgroundControls(session, changed);
  const { filters } = session.schema.properties;
  if (filters) filterControls(session, filters, changed);
  $("accuracy-reset").addEventListener("click", () => {
    session.accuracySettings = {};
    drawAccuracy();
    changed();
  });
  tabs(document.querySelector("[role=tablist]"), () => { $("hint").textContent = ""; });
  listenToBar();
  sharing = connectSharing({ session, changed, paths: schema.paths, fullRequest: () => frameRequest(frames.size()) });
  connectPicture({ fullRequest: () => frameRequest(frames.size()), titleOf: (id) => choice.titleOf(id),
                   formats: session.schema.properties.output.properties.format.enum });
  new Uploads({ choice, maps, maxBytes: renderer.limits.uploadBytes });
  connectTips();
  $("maps-show").addEventListener("click", () => showMaps(frameRequest(frames.size())));
  $("camera").addEventListener("change", () => {
    session.useCamera($("camera").value);
    changed();
  });
  addEventListener("hashchange", () => location.reload());
  const first = await choice.list(fromLink.scene);
  if (first !== undefined) await choice.choose(first, fromLink.view);
}

// The token is kept until the tab is closed.
function askForToken() {
  clearMessage();
  $("token-form").hidden = false;
  $("token-rejected").textContent = sessionStorage.getItem("token") ? "The server rejected this token." : "";
  $("token").value = "";
  $("token").focus();
}
$("token-form").addEventListener("submit", (e) => {
  e.preventDefault();
  sessionStorage.setItem("token", $("token").value);
  useToken($("token").value);
  $("token-form").hidden = true;
  $("token-rejected").textContent = "";
  begin();
});

// Retries if the server is unreachable while the page opens.
async function begin(failures = 1) {
  try {
    await start();
  } catch (problem) {
    if (!(problem instanceof Problem)) throw problem;
    if (problem.status === 401 && !session) return askForToken();
    const seconds = messageOf(problem).retry && !session ? retryDelay(problem.retryAfterSeconds, failures) : undefined;
    showProblem(problem, seconds);
    if (seconds !== undefined) setTimeout(() => begin(failures + 1), 1000 * seconds);
  }
}
useToken(sessionStorage.getItem("token") ?? "");
begin();
