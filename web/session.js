// The state of the page: scene, camera, and a value for every field; converted to requests and links and back. Pure.
import { fromDirection, fromLookAt, lensFor, positionOf } from "./camera.js";
import { numbered, sceneIdOf, withoutScene } from "./joined.js";
import { queryOf, requestOf, rounded } from "./links.js";
import { withField } from "./lists.js";
import { defaultsOf, fieldsOfType, objectOf } from "./schema.js";

// Fields with controls elsewhere on the page; the others have controls under "Image".
const kHandledElsewhere = ["scene", "camera", "width", "height", "time", "clip", "variant", "effects", "accuracy", "environment", "overrides",
                 "filters", "output", "background", "nodes", "lights", "ground"];

const shortened = (x) => Number(x.toPrecision(4));

export class Session {
  scene;   // GET v1/scenes/{id}
  camera;  // see camera.js
  start;   // the view of "Reset view"
  preset;
  accuracySettings = {};  // that differ from the preset
  time = 0;
  clip;  // animation of the scene; undefined: the default of the server
  variant;  // of the scene's materials; undefined: the default ones
  filters = [];
  lights = [];  // `lights` of the request
  ground;  // likewise; undefined: none
  background;  // likewise; undefined: the environment map
  nodes = [];  // likewise; names of nodes and materials are preceded by that of their scene
  parts = [];  // scenes that are joined to the scene partsOf: entries of `scene` of the request, with names
  partsOf;     // id of a scene
  headingDegrees = 0;  // rotation of the environment map about +Y

  // frame: the schema of FrameRequest without references.
  constructor(frame) {
    this.schema = frame;
    const { properties } = frame;
    const accuracy = objectOf(properties.accuracy);
    this.presets = accuracy.properties.preset.enum;
    this.accuracySchemas = Object.fromEntries(Object.entries(accuracy.properties).filter(([name]) => name !== "preset"));
    this.presetValues = accuracy["x-presets"] ?? {};
    this.imageSchemas = Object.fromEntries(Object.entries(properties).filter(([name]) => !kHandledElsewhere.includes(name)));
    this.setDefaults();
  }

  setDefaults() {
    const defaults = defaultsOf(this.schema);
    this.preset = this.schema.properties.accuracy.default;
    this.accuracySettings = {};
    this.effects = { ...defaults.effects };
    this.environment = { ...defaults.environment };
    this.image = Object.fromEntries(Object.keys(this.imageSchemas)
      .filter((name) => defaults[name] !== undefined).map((name) => [name, defaults[name]]));
    this.filters = [];
    this.lights = [];
    this.ground = undefined;
    this.background = undefined;
    this.nodes = [];
    this.parts = [];
    this.headingDegrees = 0;
    this.time = 0;
    this.clip = undefined;
    this.variant = undefined;
  }

  // The value of a setting of `accuracy`: set explicitly, or that of the preset.
  accuracyValue(name) {
    return this.accuracySettings[name] ?? this.presetValues[this.preset]?.[name];
  }
  get accuracy() {
    return { preset: this.preset, ...this.accuracySettings };
  }

  // What the request changes of the lights of a name, or of all (name: undefined). A field, or all of it.
  lightValue(name, field) {
    const entry = this.#light(name);
    return field === undefined ? entry : entry?.[field];
  }
  // Sets one field, or removes it (value: undefined); without a field everything of these lights.
  setLight(name, field, value) {
    const others = this.lights.filter((entry) => entry !== this.#light(name));
    const entry = withField(this.#light(name), name === undefined ? {} : { light: name }, field, value) ?? [];
    // Later entries override earlier ones: those of all lights come first.
    this.lights = name === undefined ? [entry, others].flat() : [others, entry].flat();
  }
  #light(name) {
    return this.lights.find((entry) => entry.light === name && entry.type === undefined);
  }

  // Adds a light at the camera that shines where it looks, as bright there as sunlight through thin clouds: 3 lux reflect
  // a radiance of nearly 1.
  addLight(type) {
    const { target } = this.camera, position = positionOf(this.camera);
    const forward = target.map((x, i) => x - position[i]), distance = Math.hypot(...forward);
    const taken = new Set([...(this.scene.lights ?? []), ...this.lights].map((l) => l.light ?? l.name));
    const light = numbered("light", (name) => taken.has(name));
    const intensity = type === "directional" ? 3 : 3 * distance ** 2;
    this.lights.push({ light, type, intensity: Number(intensity.toPrecision(2)),
                       ...(type === "directional" ? {} : { position: position.map(shortened) }),
                       ...(type === "point" ? {} : { direction: forward.map((x) => shortened(x / distance)) }) });
  }
  get addedLights() {
    return this.lights.filter(({ type }) => type !== undefined);
  }
  removeLight(entry) {
    this.lights = this.lights.filter((other) => other !== entry);
  }

  // Joins a scene (GET v1/scenes/{id}) to that of the view, with its middle at the target of the camera.
  addPart({ id, bounds }) {
    const taken = new Set([this.scene.id, ...this.parts.map(({ name }) => name)]);
    const middle = bounds ? bounds.min.map((x, i) => (x + bounds.max[i]) / 2) : [0, 0, 0];
    const translation = this.camera.target.map((x, i) => shortened(x - middle[i]));
    this.parts.push({ scene: id, name: taken.has(id) ? numbered(id, (name) => taken.has(name)) : id, translation });
    this.partsOf = this.scene.id;
  }
  removePart(part) {
    this.parts = this.parts.filter((other) => other !== part);
    this.#dropUnknownNodes();
  }

  // The scene of requests.
  get joined() {
    const { id } = this.scene;
    return this.parts.length ? [{ scene: id, name: id }, ...this.parts] : id;
  }
  // The name in requests of what belongs to the scene of the view.
  #sent(name) {
    return this.parts.length ? `${this.scene.id}/${name}` : name;
  }
  // The names of nodes and materials as the session has them, from those of requests and answers; and the inverse.
  nodeName(sent) {
    return this.parts.length ? sent : `${this.scene.id}/${sent}`;
  }
  #sentNode(name) {
    return this.parts.length ? name : withoutScene(name, this.scene.id);
  }

  // What the request changes of the nodes of a name.
  nodeValue(name, field) {
    const entry = this.nodes.find(({ node }) => node === name);
    return field === undefined ? entry : entry?.[field];
  }
  // As setLight().
  setNode(name, field, value) {
    const entry = this.nodeValue(name);
    this.nodes = [this.nodes.filter((other) => other !== entry), withField(entry, { node: name }, field, value) ?? []].flat();
  }
  #dropUnknownNodes() {
    const scenes = [this.scene.id, ...this.parts.map(({ name }) => name)];
    const isKnown = (name) => name === undefined || scenes.some((scene) => name.startsWith(`${scene}/`));
    this.nodes = this.nodes.filter(({ node, material }) => isKnown(node) && isKnown(material));
  }

  // Removes what refers to another scene's parts, lights and nodes.
  keepOwn() {
    if (this.partsOf !== this.scene.id) this.parts = [];
    this.#dropUnknownNodes();
    const names = new Set((this.scene.lights ?? []).map((l) => l.name));
    this.lights = this.lights.filter(({ light, type }) => light === undefined || type !== undefined || names.has(light));
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

  // Diagonal of the scene in metres, to which speeds are proportional.
  get sceneSize() {
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
      ...(this.clip === undefined ? {} : { clip: this.#sent(this.clip) }),
      ...(this.variant === undefined ? {} : { variant: this.#sent(this.variant) }),
      effects: this.effects,
      accuracy: this.accuracy,
      environment,
      ...(this.lights.length ? { lights: this.lights.map((entry) =>
        (entry.type === undefined && entry.light !== undefined ? { ...entry, light: this.#sent(entry.light) } : entry)) } : {}),
      ...(this.ground ? { ground: this.ground } : {}),
      ...(this.background ? { background: this.background } : {}),
      ...(this.nodes.length ? { nodes: this.nodes.map(({ node, material, ...entry }) => ({ node: this.#sentNode(node), ...entry,
        ...(material === undefined ? {} : { material: this.#sentNode(material) }) })) } : {}),
      ...(this.filters.length ? { filters: this.filters } : {}),
      ...this.image,
    };
  }

  // size: [width, height] in pixels. draft: use the cheapest accuracy. scale: of a small frame relative to a full one,
  // along an edge; filter fields in pixels are multiplied by it.
  request([width, height], { draft = false, scale = 1 } = {}) {
    const { camera } = this;
    return rounded({
      scene: this.joined,
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

  // For the address of the page: everything except the size, which depends on the window.
  query() {
    const { target, yfov } = this.camera;
    return queryOf(rounded({ scene: this.joined, camera: { position: positionOf(this.camera), target, yfov },
                             ...this.#fields() }));
  }

  // Applies such an address. -> its scene and view, if any; the view applies when the scene is loaded.
  read(query) {
    const { scene, camera, time, clip, variant, effects, accuracy, environment, lights, ground, background, nodes, filters, ...rest } = requestOf(query, this.schema);
    Object.assign(this.effects, effects);
    if (accuracy) {
      const { preset, ...settings } = typeof accuracy === "string" ? { preset: accuracy } : accuracy;
      this.preset = preset ?? this.preset;
      this.accuracySettings = settings;
    }
    const { rotation, ...other } = environment ?? {};
    Object.assign(this.environment, other);
    if (rotation) this.headingDegrees = Math.round((2 * Math.atan2(rotation[1], rotation[3]) * 180) / Math.PI * 10) / 10;
    const id = sceneIdOf(scene);
    if (Array.isArray(scene)) Object.assign(this, { parts: scene.slice(1), partsOf: id });
    const own = (name) => (this.parts.length && name !== undefined ? withoutScene(name, id) : name);
    if (lights) this.lights = lights.map((entry) => (entry.type === undefined && entry.light ? { ...entry, light: own(entry.light) } : entry));
    if (ground) this.ground = ground;
    if (Array.isArray(background)) this.background = background;
    const whole = (name) => (this.parts.length ? name : `${id}/${name}`);
    if (nodes && id !== undefined) this.nodes = nodes.map((entry) => ({ ...entry, node: whole(entry.node), ...(entry.material && { material: whole(entry.material) }) }));
    if (filters) this.filters = filters;
    if (time !== undefined) this.time = time;
    if (clip !== undefined) this.clip = own(clip);
    if (variant !== undefined) this.variant = own(variant);
    for (const name of Object.keys(this.imageSchemas)) if (rest[name] !== undefined) this.image[name] = rest[name];
    const hasPose = camera?.position && camera.target;
    return { scene: id, view: hasPose ? { yfov: 0.9, ...camera } : undefined };
  }
}
