// The scenes that are joined to that of the view, with controls for their places.
import { Problem } from "./api.js";
import { changeRow } from "./change_row.js";
import { controlFor } from "./controls.js";
import { $, fillSelect } from "./dom.js";
import { clearMessage, showFailure } from "./messages.js";
import { loadedScene } from "./scene_choice.js";

const kFields = ["translation", "rotation", "scale"];
const kNothing = { rotation: [0, 0, 0], scale: [1, 1, 1] };

export class PartRows {
  // choice: of the scene of the view. changed(): called after the joined scenes of the session change.
  constructor({ session, choice, changed }) {
    const list = session.schema.properties.scene.oneOf?.find(({ type }) => type === "array");
    Object.assign(this, { session, choice, changed, schemas: list?.items.properties });
    $("parts-part").hidden = !list;
    $("add-part").addEventListener("change", () => this.#add($("add-part").value));
  }

  sceneChanged() {
    fillSelect($("add-part"), [["", "choose…"], ...this.choice.titles], "");
    this.#draw();
  }

  async #add(id) {
    const { session, choice } = this, main = session.scene?.id;
    const isWanted = () => session.scene?.id === main && !choice.opening;
    $("add-part").value = "";
    try {
      const scene = await loadedScene(id, choice.titleOf(id), isWanted);
      if (!scene || !isWanted()) return;
      clearMessage();
      session.addPart(scene);
    } catch (problem) {
      if (!(problem instanceof Problem)) throw problem;
      return showFailure(`${choice.titleOf(id)} could not be loaded`, problem);
    }
    this.#draw();
    this.changed();
  }

  #draw() {
    $("parts").replaceChildren(...this.session.parts.map((part) => this.#row(part)));
  }

  #row(part) {
    return changeRow({
      name: this.choice.titleOf(part.scene), quiet: part.name === part.scene ? "" : part.name,
      tip: `The scene “${part.name}”, added to this view only.`,
      resetLabel: "Remove", resetTip: "Removes the scene from this view", isSet: () => true,
      reset: () => {
        this.session.removePart(part);
        this.#draw();
        $("add-part").focus();
      },
      changed: this.changed,
      controls: (changed) => kFields.map((field) => {
        const { oneOf, ...rest } = this.schemas[field];
        // Of the forms of a rotation, the angles.
        const schema = { ...rest, ...oneOf?.find(({ minItems }) => minItems === 3) };
        return controlFor(field, schema, part[field] ?? kNothing[field], (value) => {
          part[field] = value;
          changed();
        });
      }),
    });
  }
}
