// The time slider and its play button; there only while the scene lists clips that move it.
import { $, fillSelect } from "./dom.js";

const kUsual = "\u0000usual";  // no clip has this name

// Seconds that a scene's slider spans: the chosen clip, or the longest one.
export function spanOf({ animations = [] }, clip) {
  const asked = animations.filter((a) => clip === undefined || a.name === clip);
  return asked.length ? Math.max(...asked.map((a) => a.duration ?? 0)) || 10 : 0;
}

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
    $("clip").addEventListener("change", () => {
      session.clip = $("clip").value === kUsual ? undefined : $("clip").value;
      this.#span = spanOf(session.scene, session.clip);
      $("time").max = this.#span;
      this.#set(Math.min(session.time, this.#span));
    });
  }

  sceneChanged() {
    const { session } = this;
    this.#pause();
    const names = (session.scene.animations ?? []).map((a) => a.name);
    if (!names.includes(session.clip)) session.clip = undefined;
    this.#span = spanOf(session.scene, session.clip);
    $("time-row").hidden = this.#span === 0;
    if (this.#span === 0) session.time = 0;
    fillSelect($("clip"), [[kUsual, "usual clip"], ...names.map((name) => [name, name])], session.clip ?? kUsual);
    $("clip").hidden = names.length < 2 || !("clip" in session.schema.properties);
    $("time").max = this.#span;
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
