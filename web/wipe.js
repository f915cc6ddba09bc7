// Compares the view with two settings, to the left and right of a movable line.
import { imageAt } from "./api.js";
import { $, element, fillSelect, showBlob } from "./dom.js";

// The choices for either side: [key, label]. effects: their names.
export const wipeChoices = (presets, effects, labelOf) => [
  ["now", "current setting"], ...presets.map((p) => [`preset:${p}`, `accuracy ${p}`]),
  ...effects.map((e) => [`off:${e}`, `without ${labelOf(e).toLowerCase()}`]), ["off:all", "all effects off"],
];

// The request with such a choice.
export function withChoice(request, key) {
  const [kind, what] = key.split(":");
  if (kind === "preset") return { ...request, accuracy: what };
  if (kind !== "off") return request;
  const effects = Object.fromEntries(Object.entries(request.effects).map(([name, on]) => [name, on && what !== "all" && name !== what]));
  return { ...request, effects };
}

const kParts = ["after", "wipe", "wipe-line", "tag-before", "tag-after"];

export class Wipe {
  on = false;

  constructor(choices, changed) {
    fillSelect($("before"), choices, "now");
    fillSelect($("wipe-with"), choices, "off:all");
    const set = () => $("stage").style.setProperty("--wipe", `${$("wipe").value}%`);
    $("wipe").addEventListener("input", set);
    set();
    for (const id of ["before", "wipe-with"]) $(id).addEventListener("change", () => this.on && changed());
    $("wipe-start").addEventListener("click", () => {
      this.on = !this.on;
      $("wipe-start").setAttribute("aria-pressed", this.on);
      $("wipe-start").textContent = this.on ? "Stop comparing" : "Compare";
      if (!this.on) this.hide();
      changed();
    });
  }

  // Adds the reference image as a choice, or removes it if there is no path.
  setReference(path) {
    this.reference = path;
    const right = $("wipe-with"), option = right.querySelector("[value=reference]");
    if (path && !option) right.append(element("option", { value: "reference", textContent: "path-traced reference" }));
    if (!path && option) {
      const selected = right.value === "reference";
      option.remove();
      if (selected) right.value = "off:all";
    }
  }

  // Shows the right side: the reference image or the frame of render(request).
  async showRight(request, render) {
    const right = $("wipe-with").value;
    const blob = right === "reference" ? await imageAt(this.reference) : (await render(withChoice(request, right))).blob;
    await showBlob($("after"), blob);
    this.#show();
  }

  left(request) {
    return this.on ? withChoice(request, $("before").value) : request;
  }
  hide() {
    for (const id of kParts) $(id).hidden = true;
  }
  #show() {
    for (const id of kParts) $(id).hidden = false;
    $("tag-before").textContent = $("before").selectedOptions[0].textContent;
    $("tag-after").textContent = $("wipe-with").selectedOptions[0].textContent;
  }
}
