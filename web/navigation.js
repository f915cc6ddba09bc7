// Camera movement by pointers and keys. Pure.
//
// Flight integrates acceleration along the axes of the camera, velocity and position (semi-implicit Euler) in fixed time
// steps, so that the same keys at the same times fly the same path at any frame rate.
import { axesOf, moved } from "./camera.js";

// ---- gestures --------------------------------------------------------------------------------

// Points are [x, y] in CSS pixels; `side` is the shorter side of the image, which the field of view spans.

// A drag over the whole side rotates by this angle.
const kRadiansPerSide = Math.PI;

const midpoint = ([a, b]) => [(a[0] + b[0]) / 2, (a[1] + b[1]) / 2];
const distanceOf = ([a, b]) => Math.hypot(a[0] - b[0], a[1] - b[1]);

// One point orbits, or pans if `panning`; two pan by their midpoint and zoom by their distance.
export function gestureOf(before, after, side, panning = false) {
  if (before.length === 1) {
    const [dx, dy] = [(after[0][0] - before[0][0]) / side, (after[0][1] - before[0][1]) / side];
    return panning
      ? { kind: "pan", dx, dy, zoom: 1 }
      : { kind: "orbit", dx: dx * kRadiansPerSide, dy: dy * kRadiansPerSide };
  }
  const [from, to] = [midpoint(before), midpoint(after)];
  const [was, is] = [distanceOf(before), distanceOf(after)];
  return {
    kind: "pan",
    dx: (to[0] - from[0]) / side,
    dy: (to[1] - from[1]) / side,
    zoom: was > 0 && is > 0 ? was / is : 1,
  };
}

// deltaMode as in WheelEvent: 0 pixels, 1 lines, 2 pages. About 10 % per notch.
export function wheelZoom(deltaY, deltaMode) {
  const pixels = deltaY * [1, 16, 400][deltaMode];
  return Math.exp(Math.min(240, Math.max(-240, pixels)) * 0.001);
}

// ---- flight ----------------------------------------------------------------------------------

export const kStep = 1 / 240;  // seconds
const kDrag = 5;               // per second: the speed falls to a fifth in 0.3 s
const kRest = 1e-3;            // of full speed; slower movement stops

const kDirections = {  // right, up, front
  KeyD: [1, 0, 0], KeyA: [-1, 0, 0], KeyE: [0, 1, 0], KeyQ: [0, -1, 0], KeyW: [0, 0, 1], KeyS: [0, 0, -1],
};
export const isFlightKey = (code) => code in kDirections;

// The direction of the pressed keys; its length is at most 1, so that diagonals are not faster.
export function directionOf(codes) {
  const sum = [0, 0, 0];
  for (const code of codes) kDirections[code]?.forEach((x, i) => { sum[i] += x; });
  const length = Math.hypot(...sum);
  return length > 1 ? sum.map((x) => x / length) : sum;
}

export class Flight {
  #start;
  #steps = 0;
  #pressed = new Set();
  velocity = [0, 0, 0];  // metres per second, world space

  // speed: metres per second while a key is held. inertia: whether the camera slows down gradually after release.
  constructor(seconds, { inertia = true } = {}) {
    this.#start = seconds;
    this.inertia = inertia;
    this.speed = 1;
  }

  // Moves the camera up to this time. Must be called before keys, speed or camera change.
  advance(camera, seconds) {
    // The tolerance keeps a time at the end of a step from rounding to the step before.
    const until = Math.floor((seconds - this.#start) / kStep + 1e-6);
    if (!this.moving) {
      this.#steps = Math.max(this.#steps, until);
      return camera;
    }
    const { right, up, toEye } = axesOf(camera);
    const input = directionOf(this.#pressed);
    const target = right.map((x, i) => input[0] * x + input[1] * up[i] - input[2] * toEye[i]);
    const step = [0, 0, 0];
    for (; this.#steps < until; ++this.#steps) {
      this.velocity = this.velocity.map((v, i) =>
        (v + target[i] * this.speed * kDrag * kStep) / (1 + kDrag * kStep));
      this.velocity.forEach((v, i) => { step[i] += v * kStep; });
      if (!this.#pressed.size && Math.hypot(...this.velocity) < kRest * this.speed) this.velocity = [0, 0, 0];
    }
    return moved(camera, step);
  }

  press(code) {
    if (isFlightKey(code)) this.#pressed.add(code);
  }
  release(code) {
    this.#pressed.delete(code);
    if (!this.inertia && !this.#pressed.size) this.velocity = [0, 0, 0];
  }
  releaseAll() {
    for (const code of [...this.#pressed]) this.release(code);
  }
  get moving() {
    return this.#pressed.size > 0 || this.velocity.some((v) => v !== 0);
  }
}
