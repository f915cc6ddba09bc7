// The lights of the scene, with a control for each field that a request can change.
import { controlFor } from "./controls.js";
import { $, element } from "./dom.js";
import { grouped } from "./lists.js";

const kSelectors = ["light", "type"];
const kOfKind = {  // fields that other kinds of light do not have
  position: ["point", "spot"], range: ["point", "spot"], direction: ["spot", "directional"],
  innerConeAngle: ["spot"], outerConeAngle: ["spot"],
};

// Lights that one name selects: [{ name, kind, count, light }]. An override without a name changes all lights: it comes first
// if there are several names, or lights without one.
export function lightGroups(lights) {
  const named = [...grouped(lights.filter((l) => l.name), (l) => l.name)].map(([name, all]) => (
    { name, kind: all[0].kind, count: all.length, light: all[0] }));
  const first = { name: undefined, kind: undefined, count: lights.length, light: {} };
  return lights.length > 0 && (named.length !== 1 || lights.some((l) => !l.name)) ? [first, ...named] : named;
}

// The value of a field in the loaded scene. In a request, intensity is a number and colour the rest.
export function ownValue({ intensity, ...light }, field) {
  const greatest = intensity && Math.max(...intensity);
  switch (field) {
    case "enabled": return true;
    case "intensity": return greatest;
    case "color": return greatest > 0 ? intensity.map((c) => Number((c / greatest).toPrecision(4))) : undefined;
    case "radius":
    case "range": return light[field] ?? (light.kind ? 0 : undefined);
    default: return light[field];
  }
}

// Slider ranges in the order of the light's own values.
export function lightRange(field, light, sceneSize) {
  const own = ownValue(light, field);
  return { radius: light.kind === "directional" ? [0, 0.1] : [0, 0.05 * sceneSize], range: [0, 2 * sceneSize],
           intensity: [0, own > 0 ? 4 * own : 100] }[field];
}

export class LightRows {
  // changed(): called after a light of the session changes.
  constructor(session, changed) {
    Object.assign(this, { session, changed });
    this.fields = Object.entries(session.schema.properties.lights?.items.properties ?? {}).filter(([name]) => !kSelectors.includes(name));
  }

  sceneChanged() {
    const groups = this.fields.length ? lightGroups(this.session.scene.lights ?? []) : [];
    $("lights-part").hidden = groups.length === 0;
    $("lights").replaceChildren(...groups.map((group) => this.#row(group)));
  }

  #row({ name, kind, count, light }) {
    const { session } = this;
    const set = (field, value) => {
      session.setLight(name, field, value);
      mark();
      this.changed();
    };
    const summary = element("summary", { title: name === undefined ? "Changes every light of the scene; rows below replace it for their light."
      : `Changes the light “${name}” in this view only.` },
      element("b", {}, name ?? "All lights"), element("span", { className: "quiet" }, count > 1 ? ` × ${count}` : kind ?? ""));
    const reset = element("button", { type: "button", className: "plain", title: "Restores the values of the scene", onclick: () => {
      session.setLight(name);
      const fresh = this.#row({ name, kind, count, light });
      fresh.open = true;
      row.replaceWith(fresh);
      fresh.querySelector("summary").focus();
      this.changed();
    } }, "Reset");
    const controls = this.fields.filter(([field]) => !kind || (kOfKind[field] ?? [kind]).includes(kind)).flatMap(([field, schema]) => {
      const value = session.lightValue(name, field) ?? ownValue(light, field);
      return controlFor(field, schema, value, (chosen) => set(field, chosen),
        { none: value === undefined ? "none" : undefined, sliderRange: lightRange(field, light, session.sceneSize) }) ?? [];
    });
    const row = element("details", { className: "light" }, summary, ...controls, element("div", { className: "row end" }, reset));
    const mark = () => {
      const isSet = session.lightValue(name) !== undefined;
      row.classList.toggle("set", isSet);
      reset.hidden = !isSet;
    };
    mark();
    return row;
  }
}
