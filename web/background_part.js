// What is seen where there is no surface: the environment map, or a colour.
import { controlFor } from "./controls.js";
import { $ } from "./dom.js";

const kFirstColor = [1, 1, 1];

// changed(): called after the background of the session changes.
export function backgroundControls(session, changed) {
  const schema = session.schema.properties.background;
  const color = schema?.oneOf?.find(({ type }) => type === "array");
  if (!color) return;
  const choice = { type: "string", enum: ["map", "color"], description: schema.description };
  const draw = () => {
    const select = controlFor("background", choice, session.background ? "color" : "map", (word) => {
      session.background = word === "color" ? kFirstColor : undefined;
      draw();
      changed();
    });
    const numbers = session.background && controlFor("color", { ...color, description: "linear radiance: red, green, blue" }, session.background, (value) => {
      session.background = value;
      changed();
    });
    $("background").replaceChildren(select, ...(numbers ? [numbers] : []));
  };
  draw();
}
