// The objects of the view, with a control for each change of a node that the page offers.
import { instancesOf, Problem } from "./api.js";
import { changeRow } from "./change_row.js";
import { controlFor } from "./controls.js";
import { $ } from "./dom.js";
import { sceneIdOf, withoutScene } from "./joined.js";
import { grouped } from "./lists.js";

const kEdge = 320;  // pixels of the longer edge of what is counted
const kMaxRows = 64;  // as many nodes as a request may change

// Objects of one name, largest first: [{ name, share, place }]. share: of the pixels; place: of a single object, in metres.
export function objectGroups(instances, pixels) {
  const seen = instances.filter(({ node, pixels: count }) => node && count > 0);
  return [...grouped(seen, ({ node }) => node)].map(([name, all]) => ({
    name, share: all.reduce((sum, each) => sum + each.pixels, 0) / pixels,
    place: all.length === 1 ? all[0].worldFromModel.slice(12, 15).map((x) => Number(x.toPrecision(4))) : undefined,
  })).sort((a, b) => b.share - a.share).slice(0, kMaxRows);
}

export class ObjectRows {
  // request(size): of the view; undefined without one. changed(): called after a node of the session changes.
  // failed(problem): the objects could not be listed.
  constructor({ session, request, size, changed, failed }) {
    Object.assign(this, { session, request, size, changed, failed });
    this.schemas = session.schema.properties.nodes?.items.properties;
    $("objects-part").hidden = !this.schemas;
    $("objects-list").addEventListener("click", () => this.#list());
  }

  sceneChanged() {
    this.#show([]);
  }

  async #list() {
    const [w, h] = this.size(), scale = Math.min(1, kEdge / Math.max(w, h));
    const size = [w, h].map((edge) => Math.max(1, Math.round(edge * scale)));
    const request = this.request(size);
    if (!request) return;
    $("objects-list").disabled = true;
    try {
      const instances = (await instancesOf(request)).map((each) => ({ ...each, node: each.node && this.session.nodeName(each.node) }));
      if (sceneIdOf(request.scene) === this.session.scene.id) this.#show(objectGroups(instances, size[0] * size[1]));
    } catch (problem) {
      if (!(problem instanceof Problem)) throw problem;
      this.failed(problem);
    } finally {
      $("objects-list").disabled = false;
    }
  }

  // Hidden objects are not seen, but remain.
  #show(groups) {
    const others = this.session.nodes.filter(({ node }) => !groups.some(({ name }) => name === node));
    $("objects").replaceChildren(...[...others.map(({ node }) => ({ name: node })), ...groups].map((group) => this.#row(group)));
  }

  #row({ name, share, place }) {
    const { session, schemas } = this, { id, materials = [] } = session.scene;
    const shownName = withoutScene(name, id), names = [...new Set(materials)];
    return changeRow({
      name: shownName, quiet: share === undefined ? "" : `${(100 * share).toPrecision(2)} %`,
      tip: `Changes the object “${shownName}” in this view only.`,
      resetTip: "Restores the object",
      isSet: () => session.nodeValue(name) !== undefined,
      reset: () => session.setNode(name),
      changed: this.changed,
      controls: (changed) => {
        const set = (fields) => {
          for (const [field, value] of Object.entries(fields)) session.setNode(name, field, value);
          changed();
        };
        const control = (field, schema, act, options) =>
          controlFor(field, schema, session.nodeValue(name, field) ?? (field === "translation" ? place : undefined), act, options);
        return [
          control("hidden", schemas.hidden, (on) => set({ hidden: on || undefined })),
          ...(materials.length ? [control("material", { ...schemas.material, enum: names.map((each) => `${id}/${each}`), "x-titles": names },
            (material) => set({ material }), { none: "its own" })] : []),
          control("translation", { ...schemas.translation, description: "place in the world" },
            (translation) => set({ translation, relativeTo: "world" })),
        ];
      },
    });
  }
}
