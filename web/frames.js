// Asks for frames: one at a time, the newest pose wins; small ones while something moves, a full one at
// rest; later again when the server is busy or away.
import { Problem, renderFrame } from "./api.js";
import { Latest, Pace, frameSize, patience } from "./pace.js";
import { problemWords } from "./words.js";

const kMovingMs = 90;  // what a frame may take while something moves
const kRestMs = 160;   // stillness after which the full frame is asked for
const kLeastPixels = 160 * 90;

export class Frames {
  #latest = new Latest((wish) => this.#draw(wish));
  #rest;
  #waiting = false;
  #failures = 0;

  // requestFor(size, options) -> a request, or nothing while there is no view.
  // box() -> { width, height, ratio } of the picture on the screen. calm() -> motion is unwelcome.
  // shown(answer, request, still), failed(problem, secondsUntilAgain): what comes back.
  constructor({ requestFor, box, calm, limits, shown, failed }) {
    Object.assign(this, { requestFor, box, calm, limits, shown, failed });
    this.pace = new Pace({ budgetMs: kMovingMs, least: kLeastPixels, most: limits.maxPixels, pixels: 320 * 180 });
  }

  size(maxPixels = this.limits.maxPixels) {
    const { width, height, ratio } = this.box();
    return frameSize(width, height, ratio, { ...this.limits, maxPixels });
  }

  // Something moves: a quick frame now, the full one when it rests.
  moved() {
    clearTimeout(this.#rest);
    this.#rest = setTimeout(() => this.changed(), kRestMs);
    this.#ask({ still: this.calm() });
  }

  // Something was set: the full frame.
  changed() {
    clearTimeout(this.#rest);
    this.#ask({ still: true });
  }

  #ask(wish) {
    if (!this.#waiting) this.#latest.ask(wish);
  }

  async #draw({ still }) {
    const request = this.requestFor(this.size(still ? undefined : this.pace.pixels), { draft: !still && this.pace.draft });
    if (!request) return;
    try {
      const answer = await renderFrame(request, still ? "1" : "0");
      this.#failures = 0;
      if (!still) this.pace.took(request.width * request.height, answer.milliseconds);
      await this.shown(answer, request, still);
    } catch (problem) {
      if (!(problem instanceof Problem)) throw problem;
      this.#fail(problem);
    }
  }

  #fail(problem) {
    if (!problemWords(problem).waits) return this.failed(problem);
    const seconds = patience(problem.retryAfterSeconds, ++this.#failures);
    this.#waiting = true;
    setTimeout(() => {
      this.#waiting = false;
      this.changed();
    }, 1000 * seconds);
    this.failed(problem, seconds);
  }
}
