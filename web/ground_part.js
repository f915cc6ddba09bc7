// The ground below the scene: a switch, and a control for each of its fields.
import { controlFor, controlsFor } from "./controls.js";
import { $ } from "./dom.js";
import { defaultsOf } from "./schema.js";

// changed(): called after the ground of the session changes.
export function groundControls(session, changed) {
  const schema = session.schema.properties.ground;
  $("ground-part").hidden = !schema;
  if (!schema) return;
  const drawFields = () => {
    $("ground").replaceChildren();
    if (session.ground) controlsFor($("ground"), schema.properties, session.ground, changed, { height: "lowest point", size: "automatic" });
  };
  $("ground-switch").replaceChildren(controlFor("ground", { type: "boolean", description: schema.description }, session.ground !== undefined, (on) => {
    session.ground = on ? defaultsOf(schema) : undefined;
    drawFields();
    changed();
  }));
  drawFields();
}
