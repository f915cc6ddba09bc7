// What the page shows: scene, camera, and a value for every field. Turns into requests and links and
// back. Pure: no document, no network.
import { fromDirection, fromLookAt, lensFor, positionOf } from "./camera.js";
import { queryOf, requestOf, rounded } from "./links.js";
import { defaultsOf, fieldsOfType, objectOf } from "./schema.js";

// Fields with a place of their own in the page; every other one gets a control among the picture's.
const kPlaced = ["scene", "camera", "width", "height", "time", "clip", "effects", "accuracy", "environment", "overrides",
                 "filters", "output"];

export class Session {
  scene;   // GET v1/scenes/{id}
  camera;  // see camera.js
  start;   // where "back to start" goes
  preset;
  knobs = {};  // beside the preset
  time = 0;
  clip;  // of the scene's animations; none: what the server plays by itself
  filters = [];
  headingDegrees = 0;  // of the environment map, about +Y

  // frame: the schema of a frame's request.
  constructor(frame) {
    this.schema = frame;
    const { properties } = frame;
    const accuracy = objectOf(properties.accuracy);
    this.presets = accuracy.properties.preset.enum;
    this.knobSchemas = Object.fromEntries(Object.entries(accuracy.properties).filter(([name]) => name !== "preset"));
    this.presetValues = accuracy["x-presets"] ?? {};
    this.pictureSchemas = Object.fromEntries(Object.entries(properties).filter(([name]) => !kPlaced.includes(name)));
    this.setDefaults();
  }

  setDefaults() {
    const defaults = defaultsOf(this.schema);
    this.preset = this.schema.properties.accuracy.default;
    this.knobs = {};
    this.effects = { ...defaults.effects };
    this.environment = { ...defaults.environment };
    this.picture = Object.fromEntries(Object.keys(this.pictureSchemas)
      .filter((name) => defaults[name] !== undefined).map((name) => [name, defaults[name]]));
    this.filters = [];
    this.headingDegrees = 0;
    this.time = 0;
    this.clip = undefined;
  }

  // What a knob is worth now: its own value, or the preset's where the server tells it.
  knobValue(name) {
    return this.knobs[name] ?? this.presetValues[this.preset]?.[name];
  }
  get accuracy() {
    return { preset: this.preset, ...this.knobs };
  }

  goTo(view) {
    this.camera = this.start = fromLookAt(view);
  }

  // A camera of the scene by name, or its default view.
  useCamera(name) {
    const { defaultView, cameras = [] } = this.scene;
    const camera = cameras.find((c) => c.name === name);
    if (!camera) return this.goTo(defaultView);
    const distance = Math.hypot(...camera.position.map((x, i) => x - defaultView.target[i])) || 1;
    this.camera = this.start = fromDirection({ ...camera, distance });
  }

  // About how large the scene is, metres: speeds follow it.
  get reach() {
    const { bounds } = this.scene;
    if (!bounds) return 10;
    return Math.hypot(...bounds.max.map((x, i) => x - bounds.min[i])) || 1;
  }

  #fields() {
    const half = (this.headingDegrees * Math.PI) / 360;
    const environment = { ...this.environment };
    if (this.headingDegrees) environment.rotation = [0, Math.sin(half), 0, Math.cos(half)];
    return {
      ...(this.time ? { time: this.time } : {}),
      ...(this.clip === undefined ? {} : { clip: this.clip }),
      effects: this.effects,
      accuracy: this.accuracy,
      environment,
      ...(this.filters.length ? { filters: this.filters } : {}),
      ...this.picture,
    };
  }

  // size: [width, height] in pixels. draft: the cheapest accuracy, whatever is set. scale: of a full
  // frame's pixels, for filters that count in them.
  request([width, height], { draft = false, scale = 1 } = {}) {
    const { camera } = this;
    return rounded({
      scene: this.scene.id,
      camera: { position: positionOf(camera), target: camera.target, yfov: lensFor(camera.yfov, width / height) },
      width,
      height,
      ...this.#fields(),
      ...(draft ? { accuracy: this.presets[0] } : {}),
      ...(this.filters.length ? { filters: this.filters.map((filter) => this.#scaled(filter, scale)) } : {}),
    });
  }

  #scaled(filter, scale) {
    const fields = fieldsOfType(this.schema.properties.filters.items, filter.type);
    return Object.fromEntries(Object.entries(filter).map(([name, value]) =>
      [name, fields[name]?.["x-unit"] === "pixels" ? value * scale : value]));
  }

  // For the page's own address: everything but the size, which is the window's.
  query() {
    const { target, yfov } = this.camera;
    return queryOf(rounded({ scene: this.scene.id, camera: { position: positionOf(this.camera), target, yfov },
                             ...this.#fields() }), { lists: true });
  }

  // Takes over what such an address says; -> the scene that it names, if any. Its camera is for later,
  // when that scene is there.
  read(query) {
    const { scene, camera, time, clip, effects, accuracy, environment, filters, ...rest } = requestOf(query, this.schema);
    Object.assign(this.effects, effects);
    if (accuracy) {
      const { preset, ...knobs } = typeof accuracy === "string" ? { preset: accuracy } : accuracy;
      this.preset = preset ?? this.preset;
      this.knobs = knobs;
    }
    const { rotation, ...other } = environment ?? {};
    Object.assign(this.environment, other);
    if (rotation) this.headingDegrees = Math.round((2 * Math.atan2(rotation[1], rotation[3]) * 180) / Math.PI * 10) / 10;
    if (filters) this.filters = filters;
    if (time !== undefined) this.time = time;
    if (clip !== undefined) this.clip = clip;
    for (const name of Object.keys(this.pictureSchemas)) if (rest[name] !== undefined) this.picture[name] = rest[name];
    const placed = camera?.position && camera.target;
    return { scene, view: placed ? { yfov: 0.9, ...camera } : undefined };
  }
}
