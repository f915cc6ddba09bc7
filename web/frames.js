// Requests frames: one at a time, and of the poses that wait only the newest. In motion the size and accuracy that measured
// times allow; at rest they are refined up to the full frame, which a new pose aborts. Retries while the server is busy or
// unreachable.
import { Problem, renderFrame } from "./api.js";
import { messageOf } from "./messages.js";
import { Pace, ladderOf } from "./pace.js";

// ---- scheduling, without clock and network ---------------------------------------------------

// Runs one request at a time. Of the requests that arrive meanwhile only the newest is kept.
export class Latest {
  #run;
  #next;
  #busy = false;

  constructor(run) {
    this.#run = run;
  }

  request(settings) {
    this.#next = { settings };
    if (!this.#busy) this.#drain();
  }

  // Drops the request that waits.
  forget() {
    this.#next = undefined;
  }

  get busy() {
    return this.#busy;
  }
  get waiting() {
    return this.#next !== undefined;
  }

  async #drain() {
    this.#busy = true;
    try {
      while (this.#next) {
        const { settings } = this.#next;
        this.#next = undefined;
        await this.#run(settings);
      }
    } finally {
      this.#busy = false;
    }
  }
}

// The largest frame of this aspect ratio within the limits, in whole pixels.
export function frameSize(cssWidth, cssHeight, pixelRatio, { maxPixels, maxEdge }) {
  const [width, height] = [Math.max(1, cssWidth) * pixelRatio, Math.max(1, cssHeight) * pixelRatio];
  const shrink = Math.min(1, Math.sqrt(maxPixels / (width * height)), maxEdge / Math.max(width, height));
  return [Math.max(1, Math.floor(width * shrink)), Math.max(1, Math.floor(height * shrink))];
}

// Milliseconds of a frame without waiting in the queue and without compiling shaders; with the time of the network.
export function workMs({ milliseconds, timings }) {
  const other = timings.filter(({ name }) => name === "queue" || name === "compile");
  return Math.max(0.1, milliseconds - other.reduce((sum, entry) => sum + entry.milliseconds, 0));
}

// What the ladder of a request depends on besides its size; presets: cheapest first.
export function accuracyKind(accuracy, presets) {
  const { preset, ...settings } = typeof accuracy === "string" ? { preset: accuracy } : accuracy ?? {};
  if (settings.maxMilliseconds !== undefined || settings.maxError !== undefined) return "budget";
  return preset === presets[0] && Object.keys(settings).length === 0 ? "draft" : "other";
}

// Seconds until a retry: the Retry-After of the server, or longer with every consecutive failure.
export const retryDelay = (retryAfterSeconds, failures) =>
  retryAfterSeconds ?? Math.min(10, 2 ** Math.max(0, failures - 1));

// ---- requests --------------------------------------------------------------------------------

const kMovingMs = 60;  // target time of a frame in motion: the answer to a move takes up to two frames and the transfer
const kRestMs = 160;   // without motion until the frame is refined
const kFirstScale = 0.25;  // of the edges: first frame of a scene
const kMinPixels = 160 * 90;
const kInBackground = { Priority: "u=6" };  // RFC 9218: its picture is not shown

export class Frames {
  #latest = new Latest((settings) => this.#render(settings));
  #rest;
  #resting = false;  // the view has not changed for kRestMs
  #running;  // { kind, stop: AbortController } of the frame in progress, until it is shown
  #level = 0;         // of the frame that is shown
  #complete = true;   // that is the full frame, with its plan
  #pace;
  #waiting = false;   // for a retry
  #retry;             // timer of that
  #prepared;          // what a frame in motion was drawn in advance for
  #fraction = 1;  // of the pixels of a full frame, while that takes longer than the deadline of the server
  #failures = 0;
  #showing = Promise.resolve();  // the pictures so far, in their order
  #decoded;  // AbortController of the last of them

  // requestFor(size, options) -> a request, or nothing while there is no view.
  // box() -> { width, height, ratio } of the image on the screen. reducedMotion(): the user prefers reduced motion.
  // presets: cheapest first. shown(frame, request, still, signal) and failed(problem, secondsUntilRetry) are called with the result;
  // still: it is the full frame; signal: aborts what it requests in addition. A frame that exceeds the deadline of the server is requested again with half the pixels.
  // render: renderFrame(), or a replacement in tests.
  constructor({ requestFor, box, reducedMotion, limits, presets, shown, failed, render = renderFrame }) {
    Object.assign(this, { requestFor, box, reducedMotion, limits, presets, shown, failed, render });
  }

  size(maxPixels = this.limits.maxPixels) {
    const { width, height, ratio } = this.box();
    return frameSize(width, height, ratio, { ...this.limits, maxPixels });
  }

  // The camera moves: a fast frame now, finer ones when it stops.
  moved() {
    if (this.reducedMotion()) return this.#full();
    this.#restart();
    if (["full", "refined"].includes(this.#running?.kind)) this.#running.stop.abort();  // out of date
    return this.#request({ kind: "moving" });
  }

  // A setting changed: the full frame, or as if the camera moved where that takes long.
  changed() {
    this.#fraction = 1;
    if (this.#pace && !this.#pace.fullIsQuick) return this.moved();
    return this.#full();
  }

  // Another scene: a small frame as soon as possible, then the full one.
  begin() {
    this.stop();
    this.#fraction = 1;
    this.#pace = undefined;
    this.#complete = false;
    this.#resting = true;
    this.#request({ kind: "first" });
  }

  // The frames of the present view are not needed any more.
  stop() {
    clearTimeout(this.#rest);
    clearTimeout(this.#retry);
    this.#resting = false;
    this.#waiting = false;
    this.#latest.forget();
    this.#running?.stop.abort();
    this.#decoded?.abort();
  }

  // The server would draw the same view differently now.
  refresh() {
    this.#full();
  }

  #full() {
    clearTimeout(this.#rest);
    this.#resting = false;
    this.#request({ kind: "full" });
  }

  #restart() {
    clearTimeout(this.#rest);
    this.#resting = false;
    this.#rest = setTimeout(() => {
      this.#resting = true;
      if (!this.#latest.busy) this.#refine();
    }, kRestMs);
  }

  // One step, unless a newer pose waits.
  #refine() {
    if (this.#resting && !this.#complete && !this.#latest.waiting) this.#request({ kind: "refined" });
  }

  #request(settings) {
    if (!this.#waiting) this.#latest.request(settings);
  }

  // The first frame in motion after a change draws the maps of its preset and compiles its shaders, which can take a second. So
  // one is drawn while the view is at rest, once for everything but the camera, as soon as the light is complete.
  #prepareMotion({ camera, ...request }, { light }, pace) {
    if (pace.fullIsQuick || this.reducedMotion() || light?.share < 1) return;
    const key = JSON.stringify([request, light]);
    if (key === this.#prepared) return;
    this.#prepared = key;
    this.#request({ kind: "ahead" });
  }

  async #drawAhead(request) {
    await this.render(request, "0", undefined, kInBackground).catch((problem) => {
      if (!(problem instanceof Problem)) throw problem;
    });
  }

  // What was measured is kept until the size or the kind of accuracy changes.
  #paceOf({ width, height, accuracy }) {
    const ladder = ladderOf(width, height, accuracyKind(accuracy, this.presets));
    const key = JSON.stringify([width, height, ladder]);
    if (this.#pace?.key !== key) this.#pace = Object.assign(new Pace(ladder, kMovingMs), { key });
    return this.#pace;
  }

  async #render({ kind }) {
    const full = this.size(this.#fraction * this.limits.maxPixels);
    const whole = this.requestFor(full, {});
    if (!whole) return;
    const pace = this.#paceOf(whole);
    const last = pace.ladder.length - 1, small = pace.ladder.findIndex(({ scale }) => scale <= kFirstScale);
    const level = { full: 0, first: small < 0 ? last : small, moving: pace.moving, ahead: pace.moving, refined: pace.refined(Math.min(this.#level, last)) }[kind];
    const { scale, draft } = pace.ladder[level];
    const size = full.map((edge) => Math.max(1, Math.round(edge * scale)));
    const request = level === 0 ? whole : this.requestFor(size, { draft, scale });
    if (kind === "ahead") return this.#drawAhead(request);
    const still = level === 0 && kind !== "moving";
    const stop = new AbortController();
    const running = (this.#running = { kind, stop });
    try {
      const frame = await this.render(request, still ? "1" : "0", stop.signal);
      if (stop.signal.aborted) return;
      this.#failures = 0;
      // The first frame pays for what is done once per scene.
      if (kind !== "first" || level === 0) pace.measured(level, workMs(frame));
      this.#level = level;
      this.#complete = still;
      const shown = this.#showing.then(() => stop.signal.aborted || this.shown(frame, request, still, stop.signal));
      this.#showing = shown.catch(() => {});  // the next picture follows a failure too
      this.#decoded = stop;
      // A newer pose is requested while the browser decodes this picture.
      if (kind === "moving" && this.#latest.waiting) return;
      await shown;
      this.#refine();
      if (still && !stop.signal.aborted && !this.#latest.waiting) this.#prepareMotion(whole, frame, pace);
    } catch (problem) {
      if (!(problem instanceof Problem)) throw problem;
      if (!stop.signal.aborted) this.#fail(problem, request);
    } finally {
      if (this.#running === running) this.#running = undefined;
    }
  }

  #fail(problem, { width, height }) {
    if (problem.status === 504 && width * height > 2 * kMinPixels) {
      this.#fraction = (width * height) / 2 / this.limits.maxPixels;
      this.#request({ kind: "full" });
      return this.failed(problem, 0);
    }
    if (!messageOf(problem).retry) return this.failed(problem);
    const seconds = retryDelay(problem.retryAfterSeconds, ++this.#failures);
    this.#waiting = true;
    clearTimeout(this.#retry);
    this.#retry = setTimeout(() => {
      this.#waiting = false;
      this.#request({ kind: "full" });
    }, 1000 * seconds);
    this.failed(problem, seconds);
  }
}
