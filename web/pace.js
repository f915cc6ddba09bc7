// How often and how large frames are asked for. No clock and no network of its own, so it can be tested.

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

// How many pixels a moving frame may have so that it takes about `budgetMs`, from the last frame's
// count and time. Follows by at most half or double a frame, so that one slow frame does not blur the next.
export function movingPixels({ pixels, milliseconds }, budgetMs, { least, most }) {
  const change = Math.min(2, Math.max(0.5, budgetMs / Math.max(milliseconds, 0.1)));
  return Math.round(Math.min(most, Math.max(least, pixels * change)));
}
