// The time slider and its play button; there only while the scene lists clips that move it.
import { $ } from "./dom.js";

// Seconds that a scene's slider spans: its longest clip, or some of what never ends.
export const spanOf = ({ animations = [] }) =>
  (animations.length ? Math.max(...animations.map((a) => a.duration ?? 0)) || 10 : 0);

export class TimeRow {
  #span = 0;
  #playing;

  // moved(): the session's time has changed.
  constructor(session, moved) {
    Object.assign(this, { session, moved });
    $("time").addEventListener("input", () => {
      this.#pause();
      this.#set(Number($("time").value));
    });
    $("play").addEventListener("click", () => this.toggle());
  }

  sceneChanged() {
    this.#pause();
    this.#span = spanOf(this.session.scene);
    $("time-row").hidden = this.#span === 0;
    $("time").max = this.#span;
    if (this.#span === 0) this.session.time = 0;
    this.#show();
  }

  #show() {
    $("time").value = this.session.time;
    $("time-shown").textContent = `${this.session.time.toFixed(2)} s`;
  }
  #set(seconds) {
    this.session.time = seconds;
    this.#show();
    this.moved();
  }

  toggle() {
    if (this.#playing) return this.#pause();
    if (this.#span === 0) return undefined;
    const started = performance.now() / 1000 - this.session.time;
    const playing = (this.#playing = {});
    this.#tell();
    const step = () => {
      if (this.#playing !== playing) return;
      this.#set((performance.now() / 1000 - started) % this.#span);
      requestAnimationFrame(step);
    };
    requestAnimationFrame(step);
    return undefined;
  }
  #pause() {
    this.#playing = undefined;
    this.#tell();
  }
  #tell() {
    $("play").setAttribute("aria-pressed", Boolean(this.#playing));
    $("play").textContent = this.#playing ? "Pause" : "Play";
  }
}
