// Chooses size and accuracy of frames from measured milliseconds: in motion toward a target time per frame, at rest in
// steps up to the full frame. Without clock and network; the same rules as those of streams with targetMs.

// Edges relative to the full frame, largest first.
const kScales = [0.75, 0.5];
const kDraftScales = [0.5, 0.375, 0.25, 0.1875, 0.125];
const kMinPixels = 160 * 90;
const kDraftCost = 0.6;  // expected time of a frame of the cheapest preset, relative to other accuracies

const costOf = ({ scale, draft }) => scale * scale * (draft ? kDraftCost : 1);

// The levels of a full frame: [{ scale, draft }], the full frame first, each cheaper than the one before.
// accuracy: "draft" if the full frame has the cheapest accuracy; "budget" if a time or an error is its accuracy, which is
// measured per size and therefore used for full frames only; otherwise "other".
export function ladderOf(width, height, accuracy = "other") {
  const ladder = [{ scale: 1, draft: false }];
  const add = (scale, draft) => {
    const level = { scale, draft: draft && accuracy !== "draft" };
    const pixels = Math.max(1, Math.round(width * scale)) * Math.max(1, Math.round(height * scale));
    if (pixels >= kMinPixels && costOf(level) < costOf(ladder.at(-1))) ladder.push(level);
  };
  for (const scale of kScales) add(scale, accuracy === "budget");
  for (const scale of kDraftScales) add(scale, true);
  return ladder;
}

const kSlow = 1.2, kVerySlow = 2;  // of the target
const kFast = 0.8;                 // of the target, expected of the finer level
const kSlowFrames = 2, kFastFrames = 4;
const kForgetting = 0.99;          // of measured times, with every frame
const kDirect = 2;                 // of the target: the full frame needs no step before it
const kStep = 0.25;                // of the time of the full frame

export class Pace {
  #times;  // smoothed milliseconds of each level, or undefined
  #begun = false;
  #slow = 0;
  #fast = 0;

  // The first frame in motion has the coarsest level, or the one that follows from a full frame measured before.
  constructor(ladder, targetMs) {
    this.ladder = ladder;
    this.targetMs = targetMs;
    this.moving = ladder.length - 1;  // level of the next frame in motion
    this.#times = ladder.map(() => undefined);
  }

  // Milliseconds of a level: measured, or from the nearest measured levels; undefined before the first measurement.
  expected(level) {
    if (this.#times[level] !== undefined) return this.#times[level];
    const finer = this.#nearest(level, -1), coarser = this.#nearest(level, 1);
    const cost = (i) => costOf(this.ladder[i]);
    if (finer !== undefined && coarser !== undefined) {
      const share = (cost(level) - cost(coarser)) / (cost(finer) - cost(coarser));
      return this.#times[coarser] + share * (this.#times[finer] - this.#times[coarser]);
    }
    const known = finer ?? coarser;
    return known === undefined ? undefined : (this.#times[known] * cost(level)) / cost(known);
  }

  // The level after one above 0, at rest: 0, or a cheaper step before it if the full frame takes long.
  refined(level) {
    const full = this.expected(0) ?? 0;
    if (level === 0 || full <= kDirect * Math.max(this.targetMs, this.expected(level) ?? 0)) return 0;
    const step = this.#finestWithin(Math.max(kStep * full, kDirect * this.targetMs), 1);
    return step < level ? step : 0;
  }

  // Whether the full frame is fast enough for every change of a setting.
  get fullIsQuick() {
    const full = this.expected(0);
    return full === undefined || full <= kDirect * this.targetMs;
  }

  // milliseconds: without waiting and without compiling shaders.
  measured(level, milliseconds) {
    this.#times = this.#times.map((time) => (time === undefined ? undefined : kForgetting * time));
    const before = this.#times[level];
    this.#times[level] = before === undefined ? milliseconds : 0.5 * (before / kForgetting + milliseconds);
    if (!this.#begun) {
      this.#begun = true;
      return this.#moveTo(this.#finestWithin(kFast * this.targetMs, 0));
    }
    if (level !== this.moving) return undefined;
    this.#slow = milliseconds > kSlow * this.targetMs ? this.#slow + 1 : 0;
    const last = this.ladder.length - 1;
    if (level < last && (this.#slow >= kSlowFrames || milliseconds > kVerySlow * this.targetMs)) {
      this.#times = this.#times.map(() => undefined);  // the view may have changed since
      this.#times[level] = milliseconds;
      this.#moveTo(this.#finestWithin(this.targetMs, level + 1));
      this.#times[level] = Math.min(milliseconds, kVerySlow * this.targetMs);  // an interruption is soon forgotten
      return undefined;
    }
    if (level === 0) return undefined;
    this.#fast = this.#finerIsFast() ? this.#fast + 1 : 0;
    if (this.#fast >= kFastFrames) this.#moveTo(Math.min(level - 1, this.#finestWithin(kFast * this.targetMs, 0)));
    return undefined;
  }

  #finerIsFast() {
    const finer = this.moving - 1;
    const known = this.#times[finer] !== undefined || this.#nearest(finer, -1) !== undefined;
    const ratio = costOf(this.ladder[finer]) / costOf(this.ladder[this.moving]);
    // Part of the time does not depend on pixels. If the level proves slow, only two frames are lost.
    const milliseconds = known ? this.expected(finer) : this.#times[this.moving] * Math.sqrt(ratio);
    return milliseconds <= kFast * this.targetMs;
  }

  #nearest(level, step) {
    for (let i = level + step; i >= 0 && i < this.ladder.length; i += step) if (this.#times[i] !== undefined) return i;
    return undefined;
  }

  #finestWithin(milliseconds, from) {
    let level = from;
    while (level + 1 < this.ladder.length && this.expected(level) > milliseconds) ++level;
    return level;
  }

  #moveTo(level) {
    this.moving = level;
    this.#slow = this.#fast = 0;
  }
}
