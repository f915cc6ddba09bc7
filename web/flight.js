// Flying: acceleration along the camera's right, up and front, velocity, then position (semi-implicit
// Euler), slowing to rest without input. Pure.
//
// Time runs in whole steps on a grid of its own, so how often the page draws changes nothing: the same
// keys at the same moments fly the same path at 30 and at 144 frames a second.
import { axesOf, moved } from "./camera.js";

export const kStep = 1 / 240;  // seconds
const kDrag = 5;               // a second: four fifths of the speed are gone after 0.3 s
const kRest = 1e-3;            // of full speed: below it nobody sees the rest of the way

const kDirections = {  // right, up, front
  KeyD: [1, 0, 0], KeyA: [-1, 0, 0], KeyE: [0, 1, 0], KeyQ: [0, -1, 0], KeyW: [0, 0, 1], KeyS: [0, 0, -1],
};
export const flies = (code) => code in kDirections;

// What the keys held ask for; at most of length 1, so that a diagonal is no faster.
export function inputOf(codes) {
  const sum = [0, 0, 0];
  for (const code of codes) kDirections[code]?.forEach((x, i) => { sum[i] += x; });
  const length = Math.hypot(...sum);
  return length > 1 ? sum.map((x) => x / length) : sum;
}

export class Flight {
  #start;
  #steps = 0;
  #held = new Set();
  velocity = [0, 0, 0];  // metres a second, world

  // speed: metres a second that holding a key comes to. glides: false stops at once.
  constructor(seconds, { glides = true } = {}) {
    this.#start = seconds;
    this.glides = glides;
    this.speed = 1;
  }

  // Carries the camera to this moment. To be called before anything that changes keys, speed or camera.
  advance(camera, seconds) {
    const until = Math.floor((seconds - this.#start) / kStep);
    if (!this.moving) {
      this.#steps = Math.max(this.#steps, until);
      return camera;
    }
    const { right, up, toEye } = axesOf(camera);
    const input = inputOf(this.#held);
    const wanted = right.map((x, i) => input[0] * x + input[1] * up[i] - input[2] * toEye[i]);
    const step = [0, 0, 0];
    for (; this.#steps < until; ++this.#steps) {
      this.velocity = this.velocity.map((v, i) =>
        (v + wanted[i] * this.speed * kDrag * kStep) / (1 + kDrag * kStep));
      this.velocity.forEach((v, i) => { step[i] += v * kStep; });
      if (!this.#held.size && Math.hypot(...this.velocity) < kRest * this.speed) this.velocity = [0, 0, 0];
    }
    return moved(camera, step);
  }

  press(code) {
    if (flies(code)) this.#held.add(code);
  }
  release(code) {
    this.#held.delete(code);
    if (!this.glides && !this.#held.size) this.velocity = [0, 0, 0];
  }
  releaseAll() {
    for (const code of [...this.#held]) this.release(code);
  }
  get moving() {
    return this.#held.size > 0 || this.velocity.some((v) => v !== 0);
  }
}
