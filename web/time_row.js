// The time slider and its play button, shown if the scene has animations.
import { $, fillSelect } from "./dom.js";

const kDefault = "\u0000default";  // no clip has this name

// Duration in seconds of the slider: that of the selected clip, or of the longest one.
export function durationOf({ animations = [] }, clip) {
  const clips = animations.filter((a) => clip === undefined || a.name === clip);
  return clips.length ? Math.max(...clips.map((a) => a.duration ?? 0)) || 10 : 0;
}

export class TimeRow {
  #duration = 0;
  #playing;

  // moved(): called after the time of the session changes.
  constructor(session, moved) {
    Object.assign(this, { session, moved });
    $("time").addEventListener("input", () => {
      this.#pause();
      this.#set(Number($("time").value));
    });
    $("play").addEventListener("click", () => this.toggle());
    $("clip").addEventListener("change", () => {
      session.clip = $("clip").value === kDefault ? undefined : $("clip").value;
      this.#duration = durationOf(session.scene, session.clip);
      $("time").max = this.#duration;
      this.#set(Math.min(session.time, this.#duration));
    });
  }

  sceneChanged() {
    const { session } = this;
    this.#pause();
    const names = (session.scene.animations ?? []).map((a) => a.name);
    if (!names.includes(session.clip)) session.clip = undefined;
    this.#duration = durationOf(session.scene, session.clip);
    $("time-row").hidden = this.#duration === 0;
    if (this.#duration === 0) session.time = 0;
    fillSelect($("clip"), [[kDefault, "default clip"], ...names.map((name) => [name, name])], session.clip ?? kDefault);
    $("clip").hidden = names.length < 2 || !("clip" in session.schema.properties);
    $("time").max = this.#duration;
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
    if (this.#duration === 0) return undefined;
    const started = performance.now() / 1000 - this.session.time;
    const playing = (this.#playing = {});
    this.#updateButton();
    const step = () => {
      if (this.#playing !== playing) return;
      this.#set((performance.now() / 1000 - started) % this.#duration);
      requestAnimationFrame(step);
    };
    requestAnimationFrame(step);
    return undefined;
  }
  #pause() {
    this.#playing = undefined;
    this.#updateButton();
  }
  #updateButton() {
    $("play").setAttribute("aria-pressed", Boolean(this.#playing));
    $("play").textContent = this.#playing ? "Pause" : "Play";
  }
}
