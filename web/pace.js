// How often, how large and how good frames are asked for. No clock and no network of its own, so it
// can be tested.

// Runs one wish at a time. Wishes that come meanwhile replace each other: the newest wins.
export class Latest {
  #run;
  #next;
  #busy = false;

  constructor(run) {
    this.#run = run;
  }

  ask(wish) {
    this.#next = { wish };
    if (!this.#busy) this.#drain();
  }

  get busy() {
    return this.#busy;
  }

  async #drain() {
    this.#busy = true;
    try {
      while (this.#next) {
        const { wish } = this.#next;
        this.#next = undefined;
        await this.#run(wish);
      }
    } finally {
      this.#busy = false;
    }
  }
}

// The largest frame of this shape within the limits, in whole pixels.
export function frameSize(cssWidth, cssHeight, pixelRatio, { maxPixels, maxEdge }) {
  const [width, height] = [Math.max(1, cssWidth) * pixelRatio, Math.max(1, cssHeight) * pixelRatio];
  const shrink = Math.min(1, Math.sqrt(maxPixels / (width * height)), maxEdge / Math.max(width, height));
  return [Math.max(1, Math.floor(width * shrink)), Math.max(1, Math.floor(height * shrink))];
}

// What a frame in motion may take, from the last one's time: fewer pixels first; once they are as few
// as people still like, the cheapest accuracy too, until there is room again. Follows by at most half
// or double a frame, so that one slow frame does not blur the next.
export class Pace {
  constructor({ budgetMs, least, most, pixels }) {
    Object.assign(this, { budgetMs, least, most, pixels, draft: false });
  }

  took(pixels, milliseconds) {
    const change = Math.min(2, Math.max(0.5, this.budgetMs / Math.max(milliseconds, 0.1)));
    this.pixels = Math.round(Math.min(this.most, Math.max(this.least, pixels * change)));
    if (this.pixels === this.least && milliseconds > this.budgetMs) this.draft = true;
    if (this.pixels >= 6 * this.least) this.draft = false;
  }
}

// Seconds to wait before asking again: what the server said, or longer with every failure in a row.
export const patience = (retryAfterSeconds, failures) =>
  retryAfterSeconds ?? Math.min(10, 2 ** Math.max(0, failures - 1));
