// Input on the image: mouse, pen, touch, wheel, keys, and the arrow buttons for flying.
import { interpolate, look, orbit, pan, zoom } from "./camera.js";
import { Flight, gestureOf, isFlightKey, wheelZoom } from "./navigation.js";

const kKeyTurn = 0.06;     // radians per key press
const kKeyPan = 0.04;      // of the shorter side of the image
const kCrossing = 8;       // seconds to fly through the scene
const kFaster = 3;         // with shift
const kFocusMs = 350;
const seconds = () => performance.now() / 1000;

// session: has the camera. moved(): called after it changes. reducedMotion(): the user prefers reduced motion.
// focus(x, y): double click, in CSS pixels of the stage.
export class InputHandler {
  mode = "orbit";
  #points = new Map();
  #flight;
  #looping = false;
  #animation;

  constructor({ stage, session, moved, reducedMotion, focus, reset, play }) {
    Object.assign(this, { stage, session, moved, reducedMotion, focus, reset, play });
    this.#flight = new Flight(seconds(), { inertia: !reducedMotion() });
    this.#listenToPointers();
    this.#listenToKeys();
  }

  #set(camera) {
    this.#animation = undefined;
    this.session.camera = camera;
    this.moved();
  }
  #turn(dx, dy) {
    this.#fly();
    this.#set((this.mode === "fly" ? look : orbit)(this.session.camera, dx, dy));
  }
  #side() {
    return Math.min(this.stage.clientWidth, this.stage.clientHeight);
  }

  // ---- pointers -------------------------------------------------------------------------------

  #listenToPointers() {
    const { stage } = this;
    const points = this.#points;
    stage.addEventListener("pointerdown", (e) => {
      if (e.target.closest("input, button, form")) return;
      stage.setPointerCapture(e.pointerId);
      points.set(e.pointerId, [e.clientX, e.clientY]);
    });
    stage.addEventListener("pointermove", (e) => {
      if (!points.has(e.pointerId) || !this.session.camera) return;
      const before = [...points.values()].slice(0, 2);
      points.set(e.pointerId, [e.clientX, e.clientY]);
      const g = gestureOf(before, [...points.values()].slice(0, 2), this.#side(), e.shiftKey || (e.buttons & 6) !== 0);
      if (g.kind === "orbit") this.#turn(g.dx, g.dy);
      else this.#set(zoom(pan(this.session.camera, g.dx, g.dy), g.zoom));
    });
    for (const end of ["pointerup", "pointercancel"]) stage.addEventListener(end, (e) => points.delete(e.pointerId));
    stage.addEventListener("contextmenu", (e) => e.preventDefault());
    stage.addEventListener("wheel", (e) => {
      if (!this.session.camera) return;
      e.preventDefault();
      this.#set(zoom(this.session.camera, wheelZoom(e.deltaY, e.deltaMode)));
    }, { passive: false });
    stage.addEventListener("dblclick", (e) => {
      if (e.target.closest("input, button, form")) return;
      const box = stage.getBoundingClientRect();
      this.focus(e.clientX - box.left, e.clientY - box.top);
    });
  }

  // ---- keys -----------------------------------------------------------------------------------

  #listenToKeys() {
    const step = {
      ArrowLeft: [1, 0], ArrowRight: [-1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1],
    };
    this.stage.addEventListener("keydown", (e) => {
      if (e.ctrlKey || e.metaKey || e.altKey || !this.session.camera || e.target !== this.stage) return;
      const { camera } = this.session, key = e.key.toLowerCase();  // Caps Lock changes letters
      if (isFlightKey(e.code)) this.press(e.code, e.shiftKey);
      else if (step[e.key] && e.shiftKey) this.#set(pan(camera, ...step[e.key].map((x) => x * kKeyPan)));
      else if (step[e.key]) this.#turn(...step[e.key].map((x) => x * kKeyTurn));
      else if (e.key === "+" || e.key === "=") this.#set(zoom(camera, 1 / 1.1));
      else if (e.key === "-") this.#set(zoom(camera, 1.1));
      else if (key === "f") this.focus(this.stage.clientWidth / 2, this.stage.clientHeight / 2);
      else if (key === "r") this.reset();
      else if (e.key === " ") this.play();
      else return;
      e.preventDefault();
    });
    this.stage.addEventListener("keyup", (e) => {
      if (isFlightKey(e.code)) this.release(e.code);
      else if (e.key === "Shift") this.#changeFlight(() => { this.#flight.speed = this.#speed(false); });
    });
    this.stage.addEventListener("keydown", (e) => {
      if (e.key === "Shift") this.#changeFlight(() => { this.#flight.speed = this.#speed(true); });
    });
    const stop = () => this.#changeFlight(() => this.#flight.releaseAll());
    this.stage.addEventListener("blur", stop);
    window.addEventListener("blur", stop);
  }

  // ---- flying ---------------------------------------------------------------------------------

  #speed(fast) {
    return (this.session.sceneSize / kCrossing) * (fast ? kFaster : 1);
  }

  // Advances the flight to the present time.
  #fly() {
    if (this.session.camera) this.session.camera = this.#flight.advance(this.session.camera, seconds());
  }
  #changeFlight(change) {
    if (!this.session.scene) return;
    this.#fly();
    this.#flight.inertia = !this.reducedMotion();
    change();
    this.#loop();
  }
  press(code, fast = false) {
    this.#changeFlight(() => {
      this.#animation = undefined;
      this.#flight.speed = this.#speed(fast);
      this.#flight.press(code);
    });
  }
  release(code) {
    this.#changeFlight(() => this.#flight.release(code));
  }

  #loop() {
    if (this.#looping || !this.#flight.moving) return;
    this.#looping = true;
    const draw = () => {
      this.#fly();
      this.moved();
      this.#looping = this.#flight.moving;
      if (this.#looping) requestAnimationFrame(draw);
    };
    requestAnimationFrame(draw);
  }

  // ---- animated move to a view ----------------------------------------------------------------

  animateTo(camera) {
    if (this.reducedMotion()) return this.#set(camera);
    const from = this.session.camera, start = performance.now();
    const animation = (this.#animation = {});
    const draw = () => {
      if (this.#animation !== animation) return;
      const t = Math.min(1, (performance.now() - start) / kFocusMs);
      this.session.camera = interpolate(from, camera, t * t * (3 - 2 * t));
      this.moved();
      if (t < 1) requestAnimationFrame(draw);
    };
    requestAnimationFrame(draw);
  }
}

// Buttons that fly while they are pressed.
export function connectFlightButtons(pad, input) {
  for (const button of pad.querySelectorAll("button")) {
    const { code } = button.dataset;
    const start = (e) => {
      e.preventDefault();
      input.press(code);
    };
    button.addEventListener("pointerdown", start);
    for (const end of ["pointerup", "pointercancel", "pointerleave", "blur"]) button.addEventListener(end, () => input.release(code));
    button.addEventListener("keydown", (e) => (e.key === " " || e.key === "Enter") && !e.repeat && start(e));
    button.addEventListener("keyup", () => input.release(code));
  }
}
