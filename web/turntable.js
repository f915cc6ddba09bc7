// Turns the camera about its target at constant speed.
import { $ } from "./dom.js";
import { orbit } from "./camera.js";

const kTurnSeconds = 16;
const kPauseSeconds = 2;   // after the last input
const kStill = Math.PI / 6;  // of one press with reduced motion

export const turned = (camera, seconds) => orbit(camera, (-2 * Math.PI * seconds) / kTurnSeconds, 0);

// When it turns: not while input arrives, and not until kPauseSeconds after it. Without clock; times in seconds.
export class Rotation {
  #last;
  #pausedUntil = 0;

  input(now) {
    this.#pausedUntil = now + kPauseSeconds;
  }
  // -> seconds to turn by since the call before.
  step(now) {
    const since = this.#last === undefined || now < this.#pausedUntil ? 0 : now - this.#last;
    this.#last = now;
    return since;
  }
}

export class Turntable {
  #rotation;

  // moved(): called after the camera of the session changes. With reduced motion each press turns by a fixed angle.
  constructor({ session, moved, reducedMotion }) {
    Object.assign(this, { session, moved, reducedMotion });
    $("turntable").addEventListener("click", () => this.#toggle());
    for (const event of ["pointerdown", "pointermove", "wheel", "keydown"]) {
      $("stage").addEventListener(event, (e) => (event !== "pointermove" || e.buttons) && this.#rotation?.input(performance.now() / 1000));
    }
  }

  stop() {
    this.#rotation = undefined;
    $("turntable").setAttribute("aria-pressed", false);
  }

  #turn(camera) {
    this.session.camera = camera;
    this.moved();
  }

  #toggle() {
    if (!this.session.camera) return;
    if (this.#rotation) return this.stop();
    if (this.reducedMotion()) return this.#turn(orbit(this.session.camera, -kStill, 0));
    const rotation = (this.#rotation = new Rotation());
    $("turntable").setAttribute("aria-pressed", true);
    const draw = () => {
      if (this.#rotation !== rotation) return;
      const seconds = rotation.step(performance.now() / 1000);
      if (seconds > 0) this.#turn(turned(this.session.camera, seconds));
      requestAnimationFrame(draw);
    };
    requestAnimationFrame(draw);
  }
}
