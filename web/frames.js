// Requests frames: one at a time; the newest pose wins and aborts an outdated full frame; small frames in motion, a full one
// at rest; retries while the server is busy or unreachable.
import { Problem, renderFrame } from "./api.js";
import { messageOf } from "./messages.js";

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

  get busy() {
    return this.#busy;
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

// Size and accuracy of frames in motion, from the time of the last one: fewer pixels first; at the minimum also the
// cheapest accuracy, until frames are fast again. The size changes at most by a factor of two per frame.
export class Pace {
  constructor({ budgetMs, minPixels, maxPixels, pixels }) {
    Object.assign(this, { budgetMs, minPixels, maxPixels, pixels, draft: false });
  }

  measured(pixels, milliseconds) {
    const change = Math.min(2, Math.max(0.5, this.budgetMs / Math.max(milliseconds, 0.1)));
    this.pixels = Math.round(Math.min(this.maxPixels, Math.max(this.minPixels, pixels * change)));
    if (this.pixels === this.minPixels && milliseconds > this.budgetMs) this.draft = true;
    if (this.pixels >= 6 * this.minPixels) this.draft = false;
  }
}

// Seconds until a retry: the Retry-After of the server, or longer with every consecutive failure.
export const retryDelay = (retryAfterSeconds, failures) =>
  retryAfterSeconds ?? Math.min(10, 2 ** Math.max(0, failures - 1));

// ---- requests --------------------------------------------------------------------------------

const kMovingMs = 90;  // target time of a frame in motion
const kRestMs = 160;   // without motion until the full frame is requested
const kMinPixels = 160 * 90;

export class Frames {
  #latest = new Latest((settings) => this.#render(settings));
  #rest;
  #running;  // { still, stop: AbortController } of the frame under way
  #waiting = false;   // for a retry
  #fraction = 1;  // of the pixels of a full frame, while that takes longer than the deadline of the server
  #failures = 0;

  // requestFor(size, options) -> a request, or nothing while there is no view.
  // box() -> { width, height, ratio } of the image on the screen. reducedMotion(): the user prefers reduced motion.
  // shown(frame, request, still) and failed(problem, secondsUntilRetry) are called with the result. A frame that exceeds
  // the deadline of the server is requested again with half the pixels.
  constructor({ requestFor, box, reducedMotion, limits, shown, failed }) {
    Object.assign(this, { requestFor, box, reducedMotion, limits, shown, failed });
    this.pace = new Pace({ budgetMs: kMovingMs, minPixels: kMinPixels, maxPixels: limits.maxPixels, pixels: 320 * 180 });
  }

  size(maxPixels = this.limits.maxPixels) {
    const { width, height, ratio } = this.box();
    return frameSize(width, height, ratio, { ...this.limits, maxPixels });
  }

  // The camera moves: a fast frame now, the full one when it stops.
  moved() {
    clearTimeout(this.#rest);
    this.#rest = setTimeout(() => this.#request({ still: true }), kRestMs);
    if (this.#running?.still && !this.reducedMotion()) this.#running.stop.abort();  // out of date
    this.#request({ still: this.reducedMotion() });
  }

  // A setting changed: the full frame.
  changed() {
    clearTimeout(this.#rest);
    this.#fraction = 1;
    this.#request({ still: true });
  }

  #request(settings) {
    if (!this.#waiting) this.#latest.request(settings);
  }

  async #render({ still }) {
    const full = this.size();
    const size = this.size(still ? this.#fraction * this.limits.maxPixels : this.pace.pixels);
    const request = this.requestFor(size, { draft: !still && this.pace.draft, scale: size[0] / full[0] });
    if (!request) return;
    const stop = new AbortController();
    this.#running = { still, stop };
    try {
      const frame = await renderFrame(request, still ? "1" : "0", stop.signal);
      this.#running = undefined;
      this.#failures = 0;
      if (!still) this.pace.measured(request.width * request.height, frame.milliseconds);
      await this.shown(frame, request, still);
    } catch (problem) {
      if (!(problem instanceof Problem)) throw problem;
      if (!stop.signal.aborted) this.#fail(problem, request);
    } finally {
      this.#running = undefined;
    }
  }

  #fail(problem, { width, height }) {
    if (problem.status === 504 && width * height > 2 * kMinPixels) {
      this.#fraction = (width * height) / 2 / this.limits.maxPixels;
      this.#request({ still: true });
      return this.failed(problem, 0);
    }
    if (!messageOf(problem).retry) return this.failed(problem);
    const seconds = retryDelay(problem.retryAfterSeconds, ++this.#failures);
    this.#waiting = true;
    setTimeout(() => {
      this.#waiting = false;
      this.#request({ still: true });
    }, 1000 * seconds);
    this.failed(problem, seconds);
  }
}
