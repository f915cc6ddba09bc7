// Asks for frames: one at a time, the newest pose wins, also over a full one under way; small ones while something moves, a full one at
// rest; later again when the server is busy or away.
import { Problem, renderFrame } from "./api.js";
import { Latest, Pace, frameSize, patience } from "./pace.js";
import { problemWords } from "./words.js";

const kMovingMs = 90;  // what a frame may take while something moves
const kRestMs = 160;   // stillness after which the full frame is asked for
const kMinPixels = 160 * 90;

export class Frames {
  #latest = new Latest((wish) => this.#draw(wish));
  #rest;
  #running;  // { still, stop: AbortController } of the frame under way
  #waiting = false;
  #share = 1;  // of a full frame's pixels, while a full one takes longer than the server's deadline
  #failures = 0;

  // requestFor(size, options) -> a request, or nothing while there is no view.
  // box() -> { width, height, ratio } of the picture on the screen. calm() -> motion is unwelcome.
  // shown(answer, request, still), failed(problem, secondsUntilAgain): what comes back. A frame over the
  // server's deadline is asked for again with half its pixels.
  constructor({ requestFor, box, calm, limits, shown, failed }) {
    Object.assign(this, { requestFor, box, calm, limits, shown, failed });
    this.pace = new Pace({ budgetMs: kMovingMs, least: kMinPixels, most: limits.maxPixels, pixels: 320 * 180 });
  }

  size(maxPixels = this.limits.maxPixels) {
    const { width, height, ratio } = this.box();
    return frameSize(width, height, ratio, { ...this.limits, maxPixels });
  }

  // Something moves: a quick frame now, the full one when it rests.
  moved() {
    clearTimeout(this.#rest);
    this.#rest = setTimeout(() => this.#ask({ still: true }), kRestMs);
    if (this.#running?.still && !this.calm()) this.#running.stop.abort();  // nobody will see it
    this.#ask({ still: this.calm() });
  }

  // Something was set: the full frame.
  changed() {
    clearTimeout(this.#rest);
    this.#share = 1;
    this.#ask({ still: true });
  }

  #ask(wish) {
    if (!this.#waiting) this.#latest.ask(wish);
  }

  async #draw({ still }) {
    const full = this.size();
    const size = this.size(still ? this.#share * this.limits.maxPixels : this.pace.pixels);
    const request = this.requestFor(size, { draft: !still && this.pace.draft, scale: size[0] / full[0] });
    if (!request) return;
    const stop = new AbortController();
    this.#running = { still, stop };
    try {
      const answer = await renderFrame(request, still ? "1" : "0", stop.signal);
      this.#running = undefined;
      this.#failures = 0;
      if (!still) this.pace.took(request.width * request.height, answer.milliseconds);
      await this.shown(answer, request, still);
    } catch (problem) {
      if (!(problem instanceof Problem)) throw problem;
      if (!stop.signal.aborted) this.#fail(problem, request);
    } finally {
      this.#running = undefined;
    }
  }

  #fail(problem, { width, height }) {
    if (problem.status === 504 && width * height > 2 * kMinPixels) {
      this.#share = (width * height) / 2 / this.limits.maxPixels;
      this.#ask({ still: true });
      return this.failed(problem, 0);
    }
    if (!problemWords(problem).waits) return this.failed(problem);
    const seconds = patience(problem.retryAfterSeconds, ++this.#failures);
    this.#waiting = true;
    setTimeout(() => {
      this.#waiting = false;
      this.#ask({ still: true });
    }, 1000 * seconds);
    this.failed(problem, seconds);
  }
}
