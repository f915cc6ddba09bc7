// The choice of a material variant, shown if the scene has variants.
import { $, fillSelect } from "./dom.js";

const kDefault = "\u0000default";  // no variant has this name

export class VariantRow {
  // changed(): called after another variant is selected.
  constructor(session, changed) {
    this.session = session;
    $("variant").addEventListener("change", () => {
      session.variant = $("variant").value === kDefault ? undefined : $("variant").value;
      changed();
    });
  }

  sceneChanged() {
    const { session } = this;
    const names = session.scene.variants ?? [];
    if (!names.includes(session.variant)) session.variant = undefined;
    $("variant-row").hidden = names.length === 0;
    fillSelect($("variant"), [[kDefault, "default materials"], ...names.map((name) => [name, name])], session.variant ?? kDefault);
  }
}
