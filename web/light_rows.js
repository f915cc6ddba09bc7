// The lights of the scene and those that the view adds, with a control for each field that a request can change.
import { changeRow } from "./change_row.js";
import { controlFor } from "./controls.js";
import { $, fillSelect } from "./dom.js";
import { grouped } from "./lists.js";
import { labelOf } from "./schema.js";

const kSelectors = ["light"];
const kPlaces = ["position", "direction"];  // of one light only
const kOfKind = {  // fields that other kinds of light do not have
  position: ["point", "spot"], range: ["point", "spot"], direction: ["spot", "directional"],
  innerConeAngle: ["spot"], outerConeAngle: ["spot"],
};

// Lights that one name selects: [{ name, kind, lights }]. An override without a name changes all lights: it comes first
// if there are several names, or lights without one.
export function lightGroups(lights) {
  const named = [...grouped(lights.filter((l) => l.name), (l) => l.name)].map(([name, all]) => (
    { name, kind: all[0].kind, lights: all }));
  const first = { name: undefined, kind: undefined, lights };
  return lights.length > 0 && (named.length !== 1 || lights.some((l) => !l.name)) ? [first, ...named] : named;
}

// The value of a field in the loaded scene. In a request, intensity is a number and colour the rest.
export function ownValue({ intensity, ...light }, field) {
  const greatest = intensity && Math.max(...intensity);
  switch (field) {
    case "enabled": return true;
    case "intensity": return greatest;
    case "color": return greatest > 0 ? intensity.map((c) => Number((c / greatest).toPrecision(3))) : undefined;
    case "radius":
    case "range": return light[field] ?? (light.kind ? 0 : undefined);
    default: return light[field];
  }
}

// That of several lights; undefined if they differ.
export function commonValue(lights, field) {
  const [first, ...others] = lights.map((light) => JSON.stringify(ownValue(light, field)));
  return others.every((value) => value === first) ? ownValue(lights[0], field) : undefined;
}

// Slider ranges in the order of the light's own values.
export function lightRange(field, lights, sceneSize) {
  const own = commonValue(lights, field);
  return { radius: lights[0].kind === "directional" ? [0, 0.1] : [0, 0.05 * sceneSize], range: [0, 2 * sceneSize],
           intensity: [0, own > 0 ? 4 * own : 100] }[field];
}

export class LightRows {
  // changed(): called after a light of the session changes.
  constructor(session, changed) {
    Object.assign(this, { session, changed });
    const { type, ...fields } = session.schema.properties.lights?.items.properties ?? {};
    this.fields = Object.entries(fields).filter(([name]) => !kSelectors.includes(name));
    fillSelect($("add-light"), [["", "choose…"], ...(type?.enum ?? []).map((word) => [word, labelOf(word)])], "");
    $("add-light").addEventListener("change", () => {
      session.addLight($("add-light").value);
      $("add-light").value = "";
      this.sceneChanged();
      changed();
    });
  }

  sceneChanged() {
    const groups = this.fields.length ? lightGroups(this.session.scene.lights ?? []) : [];
    $("lights-part").hidden = this.fields.length === 0;
    $("lights").replaceChildren(...groups.map((group) => this.#row(group)),
                                ...this.session.addedLights.map((entry) => this.#addedRow(entry)));
  }

  #addedRow(entry) {
    const { session } = this;
    return changeRow({
      name: entry.light, quiet: entry.type, tip: `The light “${entry.light}” of this view.`,
      resetLabel: "Remove", resetTip: "Removes the light", isSet: () => true,
      reset: () => {
        session.removeLight(entry);
        this.sceneChanged();
        $("add-light").focus();
      },
      changed: this.changed,
      controls: (changed) => this.fields.filter(([field]) => (kOfKind[field] ?? [entry.type]).includes(entry.type)).map(([field, schema]) => {
        const value = entry[field] ?? { enabled: true, color: [1, 1, 1], radius: 0 }[field];
        return controlFor(field, schema, value, (chosen) => {
          if (chosen === undefined) delete entry[field];
          else entry[field] = chosen;
          changed();
        }, { none: value === undefined ? "none" : undefined,
             sliderRange: lightRange(field, [{ kind: entry.type, intensity: [entry.intensity] }], session.sceneSize) });
      }).filter(Boolean),
    });
  }

  #row({ name, kind, lights }) {
    const { session } = this, count = lights.length;
    const hasField = (field) => (!kind || (kOfKind[field] ?? [kind]).includes(kind)) && (count === 1 || !kPlaces.includes(field));
    return changeRow({
      name: name ?? "All lights", quiet: count > 1 ? ` × ${count}` : kind ?? "",
      tip: name === undefined ? "Changes every light of the scene; rows below replace it for their light."
        : `Changes the light “${name}” in this view only.`,
      resetTip: "Restores the values of the scene",
      isSet: () => session.lightValue(name) !== undefined,
      reset: () => session.setLight(name),
      changed: this.changed,
      controls: (changed) => this.fields.filter(([field]) => hasField(field)).flatMap(([field, schema]) => {
        const value = session.lightValue(name, field) ?? commonValue(lights, field);
        return controlFor(field, schema, value, (chosen) => {
          session.setLight(name, field, chosen);
          changed();
        }, { none: value === undefined ? "none" : undefined, sliderRange: lightRange(field, lights, session.sceneSize) }) ?? [];
      }),
    });
  }
}
