// Controls from the schema, requests from settings, and links in both directions.
import assert from "node:assert/strict";
import { test } from "node:test";

import { positionOf } from "../../web/camera.js";
import { curlOf, queryOf, requestOf, rounded } from "../../web/links.js";
import { controlOf, fieldsOfType, labelOf, newOfType, positionFor, resolved, sliderSteps, typesOf, valueAt } from "../../web/schema.js";
import { objectGroups } from "../../web/object_rows.js";
import { Session } from "../../web/session.js";
import { durationOf } from "../../web/time_row.js";
import { withChoice, wipeChoices } from "../../web/wipe.js";
import { near } from "./near.mjs";

const numbers = (count) => ({ type: "array", items: { type: "number" }, minItems: count, maxItems: count });
const object = (properties) => ({ type: "object", properties });
const flag = { type: "boolean", default: true };
const accuracySchemas = {
  preset: { type: "string", enum: ["draft", "standard"], default: "standard" },
  generations: { type: "integer", minimum: 1, maximum: 8, default: 2 },
  maxError: { type: "number", minimum: 1e-6, maximum: 1000 },
};
const filterSchemas = {
  Filter: { oneOf: [{ $ref: "#/components/schemas/TwirlFilter" }, { $ref: "#/components/schemas/ConvolveFilter" }],
            discriminator: { propertyName: "type" } },
  TwirlFilter: { required: ["type", "amount"], ...object({
    type: { type: "string", const: "twirl" },
    amount: { type: "number", minimum: -100, maximum: 100 },
    radius: { type: "number", minimum: 0, maximum: 8192, "x-unit": "pixels" },
  }) },
  ConvolveFilter: { required: ["type", "kernel"], ...object({
    type: { type: "string", const: "convolve" },
    kernel: { oneOf: [{ type: "string", enum: ["sharpen", "box"] }, numbers(9)] },
  }) },
};
const filter = resolved(filterSchemas.Filter, { components: { schemas: filterSchemas } });
const frame = object({
  scene: { oneOf: [{ type: "string", maxLength: 128 }, { type: "array", maxItems: 16, items: object({ scene: { type: "string" }, translation: numbers(3) }) }] },
  camera: object({ position: numbers(3), target: numbers(3), yfov: { type: "number", minimum: 0.01, maximum: 3 } }),
  width: { type: "integer", minimum: 1, maximum: 4096, default: 1280 },
  height: { type: "integer", minimum: 1, maximum: 4096, default: 720 },
  time: { type: "number", minimum: 0, maximum: 1e6, default: 0 },
  clip: { type: "string", maxLength: 256 },
  effects: object({ emission: flag, refraction: flag }),
  accuracy: { oneOf: [{ type: "string", enum: ["draft", "standard"] },
                      { ...object(accuracySchemas), "x-presets": { draft: { generations: 1 }, standard: { generations: 2 } } }],
              default: "standard" },
  environment: object({ map: { type: "string", maxLength: 128 }, rotation: numbers(4), visible: flag,
                        intensity: { type: "number", minimum: 0, maximum: 10000, default: 1 } }),
  lights: { type: "array", maxItems: 64, items: object({ light: { type: "string" }, radius: { type: "number", minimum: 0, maximum: 1e9 } }) },
  nodes: { type: "array", maxItems: 64, items: object({ node: { type: "string" }, hidden: { type: "boolean" }, material: { type: "string" } }) },
  background: { oneOf: [{ type: "string", enum: ["map", "transparent"] }, numbers(3)] },
  ground: object({ height: { type: "number", minimum: -1e9, maximum: 1e9 }, color: { ...numbers(3), default: [0.5, 0.5, 0.5] },
                   roughness: { type: "number", minimum: 0, maximum: 1, default: 1 }, shadowCatcher: { type: "boolean" } }),
  filters: { type: "array", maxItems: 8, items: filter },
  toneMap: { type: "string", enum: ["neutral", "aces"], default: "neutral" },
  exposure: { type: "number", minimum: -32, maximum: 32, default: 0 },
});

const scene = {
  id: "hall", bounds: { min: [0, 0, 0], max: [3, 4, 12] }, defaultView: { position: [0, 2, 5], target: [0, 1, 0], yfov: 0.9 },
  cameras: [{ name: "door", position: [1, 1, 1], direction: [0, 0, -1], yfov: 0.7 }],
};
function session() {
  const made = new Session(frame);
  made.scene = scene;
  made.useCamera("");
  return made;
}

// ---- controls ---------------------------------------------------------------------------------

test("each kind of field has its kind of control", () => {
  assert.deepEqual(controlOf("x", flag), { kind: "switch" });
  assert.deepEqual(controlOf("x", frame.properties.toneMap).words, ["neutral", "aces"]);
  assert.deepEqual(controlOf("x", fieldsOfType(filter, "convolve").kernel), { kind: "choice", words: ["sharpen", "box"] });
  assert.deepEqual(controlOf("x", numbers(4)), { kind: "vector", count: 4 });
  assert.equal(controlOf("x", frame.properties.camera).kind, "other");
  assert.equal(labelOf("planarReflection"), "Planar reflection");
});

test("sliders span the range, integers stay integers, positions and values are consistent", () => {
  for (const schema of [accuracySchemas.generations, { type: "integer", minimum: 16, maximum: 2048 }, { type: "number", minimum: 0.125, maximum: 1 },
                        { type: "number", minimum: -32, maximum: 32 }]) {
    const control = controlOf("x", schema);
    assert.equal(valueAt(control, 0), schema.minimum);
    assert.equal(valueAt(control, sliderSteps(control)), schema.maximum);
    for (let at = 0; at <= sliderSteps(control); ++at) {
      const value = valueAt(control, at);
      if (schema.type === "integer") assert.ok(Number.isInteger(value));
      assert.equal(valueAt(control, positionFor(control, value)), value);
    }
  }
  assert.equal(sliderSteps(controlOf("generations", accuracySchemas.generations)), 7);
  assert.deepEqual([controlOf("exposure", frame.properties.exposure).min, positionFor(controlOf("exposure", frame.properties.exposure), -30)], [-6, 0]);
});

test("a filter has the fields of its type, and a new one has the required ones", () => {
  assert.deepEqual(typesOf(filter), ["twirl", "convolve"]);
  assert.deepEqual(Object.keys(fieldsOfType(filter, "twirl")), ["amount", "radius"]);
  assert.deepEqual(fieldsOfType(filter, "unknown"), {});
  assert.deepEqual(newOfType(filter, "twirl"), { type: "twirl", amount: 1 });
  assert.deepEqual(newOfType(filter, "convolve"), { type: "convolve", kernel: "sharpen" });
});

// ---- requests ---------------------------------------------------------------------------------

test("a session starts with the defaults of the server and the view of its scene", () => {
  const request = session().request([640, 360]);
  assert.deepEqual(request, {
    scene: "hall", camera: { position: [0, 2, 5], target: [0, 1, 0], yfov: 0.9 }, width: 640, height: 360,
    effects: { emission: true, refraction: true }, accuracy: { preset: "standard" }, environment: { visible: true, intensity: 1 },
    toneMap: "neutral", exposure: 0,
  });
  assert.deepEqual(session().request([64, 36], { draft: true }).accuracy, "draft");
});

test("filter fields in pixels are scaled for small frames", () => {
  const made = session();
  made.filters = [{ type: "twirl", amount: 2, radius: 100 }];
  assert.deepEqual(made.request([64, 36], { scale: 0.5 }).filters, [{ type: "twirl", amount: 2, radius: 50 }]);
  assert.deepEqual(made.request([128, 72]).filters, made.filters);
});

test("a ground is in requests and links once it is set", () => {
  const made = session();
  assert.equal(made.request([64, 36]).ground, undefined);
  assert.equal(made.imageSchemas.ground, undefined);
  made.ground = { color: [0.5, 0.5, 0.5], roughness: 0.1, shadowCatcher: true };
  assert.deepEqual(made.request([64, 36]).ground, made.ground);
  const other = session();
  other.read(made.query());
  assert.deepEqual(other.ground, made.ground);
});

test("changes of lights are entries by name; those of all lights come first", () => {
  const made = session();
  made.setLight("lamp", "radius", 0.2);
  made.setLight("lamp", "enabled", false);
  made.setLight(undefined, "radius", 0.1);
  assert.deepEqual(made.request([64, 36]).lights, [{ radius: 0.1 }, { light: "lamp", radius: 0.2, enabled: false }]);
  assert.deepEqual([made.lightValue("lamp", "radius"), made.lightValue("sun", "radius"), made.lightValue(undefined, "radius")], [0.2, undefined, 0.1]);
  made.setLight("lamp", "radius", undefined);
  made.setLight(undefined);
  assert.deepEqual(made.lights, [{ light: "lamp", enabled: false }]);
  made.lights.push({ light: "new", type: "point" });
  made.scene = { ...scene, lights: [{ name: "sun" }] };
  made.keepOwn();
  assert.deepEqual(made.lights, [{ light: "new", type: "point" }], "lights of another scene are forgotten");
  made.setLight(undefined, "radius", 0);
  assert.deepEqual(made.lights, [{ radius: 0 }, { light: "new", type: "point" }]);
});

test("changes of nodes are entries by name, and belong to one scene", () => {
  const made = session();
  made.setNode("hall/cup", "hidden", true);
  made.setNode("hall/table", "material", "hall/oak");
  made.setNode("hall/cup", "material", "hall/gold");
  assert.deepEqual(made.request([64, 36]).nodes, [{ node: "table", material: "oak" }, { node: "cup", hidden: true, material: "gold" }]);
  assert.deepEqual([made.nodeValue("hall/cup", "hidden"), made.nodeValue("hall/lamp", "hidden")], [true, undefined]);
  const other = new Session(frame);
  other.read(`#${made.query()}`);
  other.scene = scene;
  other.keepOwn();
  assert.deepEqual(other.nodes, made.nodes, "a link keeps them");
  made.setNode("hall/cup", "hidden", undefined);
  made.setNode("hall/table");
  assert.deepEqual(made.nodes, [{ node: "hall/cup", material: "hall/gold" }]);
  made.scene = { ...scene, id: "yard" };
  made.keepOwn();
  assert.deepEqual(made.nodes, []);
});

test("scenes are joined at the target of the camera, with names before those of nodes and lights", () => {
  const made = session();
  made.goTo(scene.defaultView);
  made.setNode("hall/cup", "hidden", true);
  made.setLight("lamp", "radius", 0.2);
  made.clip = "swing";
  const box = { id: "box", bounds: { min: [0, 0, 0], max: [2, 2, 2] } };
  made.addPart(box);
  made.addPart(box);
  assert.equal(made.nodeName("box 1/lid"), "box 1/lid");
  made.setNode("box 1/lid", "material", "hall/gold");
  const requested = made.request([64, 36]);
  assert.deepEqual(requested.scene, [{ scene: "hall", name: "hall" }, { scene: "box", name: "box", translation: [-1, 0, -1] },
                                     { scene: "box", name: "box 1", translation: [-1, 0, -1] }]);
  assert.deepEqual(requested.nodes, [{ node: "hall/cup", hidden: true }, { node: "box 1/lid", material: "hall/gold" }]);
  assert.deepEqual(requested.lights, [{ light: "hall/lamp", radius: 0.2 }]);
  assert.equal(requested.clip, "hall/swing");
  const other = new Session(frame);
  assert.equal(other.read(`#${made.query()}`).scene, "hall");
  other.scene = { ...scene, lights: [{ name: "lamp" }] };
  other.keepOwn();
  assert.deepEqual([other.parts, other.nodes, other.lights, other.clip], [made.parts, made.nodes, made.lights, made.clip], "a link keeps them");
  made.removePart(made.parts[1]);
  assert.deepEqual(made.request([64, 36]).nodes, [{ node: "hall/cup", hidden: true }], "with the scene its changes are removed");
  made.removePart(made.parts[0]);
  assert.deepEqual([made.request([64, 36]).scene, made.request([64, 36]).nodes], ["hall", [{ node: "cup", hidden: true }]]);
  made.addPart(box);
  made.scene = { ...scene, id: "yard" };
  made.keepOwn();
  assert.equal(made.joined, "yard", "another scene is shown alone");
});

test("a light is added at the camera and shines where it looks", () => {
  const made = session();
  made.scene = { ...scene, lights: [{ name: "light 1" }] };
  made.goTo({ position: [0, 1, 5], target: [0, 1, 0], yfov: 0.9 });
  for (const type of ["spot", "point", "directional"]) made.addLight(type);
  assert.deepEqual(made.request([64, 36]).lights, [
    { light: "light 2", type: "spot", intensity: 75, position: [0, 1, 5], direction: [0, 0, -1] },
    { light: "light 3", type: "point", intensity: 75, position: [0, 1, 5] },
    { light: "light 4", type: "directional", intensity: 3, direction: [0, 0, -1] }]);
  made.removeLight(made.addedLights[1]);
  assert.deepEqual(made.addedLights.map(({ type }) => type), ["spot", "directional"]);
});

test("objects are grouped by name, the largest first", () => {
  const at = (x) => [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, x, 0, 0, 1];
  const groups = objectGroups([{ node: "cup", pixels: 10, worldFromModel: at(1) }, { node: "table", pixels: 50, worldFromModel: at(2) },
    { node: "cup", pixels: 30, worldFromModel: at(3) }, { node: "lamp", pixels: 0, worldFromModel: at(4) }], 100);
  assert.deepEqual(groups, [{ name: "table", share: 0.5, place: [2, 0, 0] }, { name: "cup", share: 0.4, place: undefined }]);
});

test("a setting of the accuracy has the value of the preset until it is set", () => {
  const made = session();
  assert.equal(made.accuracyValue("generations"), 2);
  made.preset = "draft";
  assert.equal(made.accuracyValue("generations"), 1);
  made.accuracySettings.generations = 5;
  assert.deepEqual([made.accuracyValue("generations"), made.accuracy], [5, { preset: "draft", generations: 5 }]);
});

test("a camera of the scene is applied; the size of the scene is its diagonal", () => {
  const made = session();
  made.useCamera("door");
  near(positionOf(made.camera), [1, 1, 1]);
  near([made.camera.yaw, made.camera.pitch], [0, 0]);
  assert.equal(made.sceneSize, 13);
});

test("an address restores the view and the settings", () => {
  const made = session();
  made.useCamera("door");
  Object.assign(made, { preset: "draft", accuracySettings: { generations: 4 }, time: 1.5, clip: "walk", headingDegrees: 90, filters: [{ type: "twirl", amount: 2 }],
                       lights: [{ light: "lamp, left", radius: 0.25 }], background: [0.25, 0.5, 1] });
  made.effects.refraction = false;
  made.environment.map = "a b";
  made.image.exposure = -1.25;
  const other = new Session(frame);
  const { scene: id, view } = other.read(`#${made.query()}`);
  assert.equal(id, "hall");
  other.scene = scene;
  other.goTo(view);
  assert.deepEqual(other.request([300, 200]), made.request([300, 200]));
});

test("invalid parts of an address are ignored", () => {
  const made = session();
  const { scene: id, view } = made.read("#scene&effects.emission=maybe&gone=1&camera.gone.deep=2&exposure=x&__proto__.a=1&%zz=%zz&accuracy=best");
  assert.deepEqual([id, view], [undefined, undefined]);
  assert.deepEqual(made.request([640, 360]), session().request([640, 360]));
});

test("a request is written as a link and as a curl command", () => {
  const request = rounded({ scene: "a b", camera: { position: [1, 2.00000001, 3] }, effects: { emission: false } });
  assert.equal(queryOf(request), "scene=a%20b&camera.position=1,2,3&effects.emission=false");
  assert.deepEqual(requestOf(queryOf(request), frame), request);
  assert.equal(queryOf({ filters: [{ type: "twirl" }] }), "filters=%5B%7B%22type%22%3A%22twirl%22%7D%5D");
  assert.ok(curlOf({ scene: "it's" }, "http://h/").includes(`it'\\''s`));
});

test("fields of every alternative of a tagged union are read from links", () => {
  const camera = object({ lens: { oneOf: [
    object({ type: { type: "string", const: "cube" }, layout: { type: "string", enum: ["grid", "row"] } }),
    object({ type: { type: "string", const: "fisheye" }, fov: { type: "number", minimum: 0.01, maximum: 6.3 } }),
  ] } });
  const lensOf = (query) => requestOf(query, object({ camera })).camera?.lens;
  assert.deepEqual(lensOf("camera.lens.type=fisheye&camera.lens.fov=3.3"), { type: "fisheye", fov: 3.3 });
  assert.deepEqual(lensOf("camera.lens.type=cube&camera.lens.layout=row"), { type: "cube", layout: "row" });
  assert.deepEqual(lensOf("camera.lens.type=square&camera.lens.fov=1"), { fov: 1 });
});

test("both sides of a comparison are the same view with another accuracy or without effects", () => {
  const request = session().request([64, 36]);
  assert.deepEqual(withChoice(request, "now"), request);
  assert.equal(withChoice(request, "preset:draft").accuracy, "draft");
  assert.deepEqual(withChoice(request, "off:emission").effects, { emission: false, refraction: true });
  assert.deepEqual(withChoice(request, "off:all").effects, { emission: false, refraction: false });
  assert.deepEqual(wipeChoices(["draft"], ["emission"], labelOf).map(([key]) => key), ["now", "preset:draft", "off:emission", "off:all"]);
});

test("the time slider spans the longest clip", () => {
  assert.equal(durationOf({}), 0);
  const animations = [{ name: "a", duration: 2 }, { name: "b", duration: 3 }];
  assert.deepEqual([durationOf({ animations }), durationOf({ animations }, "a")], [3, 2]);
});
