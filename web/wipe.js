// The same view with two settings, one to the left of a line and one to the right of it.
import { pictureAt } from "./api.js";
import { $, element, fillSelect, showBlob } from "./dom.js";

// What the wipe may show on either side: [key, words]. effects: their names.
export const wipeChoices = (presets, effects, words) => [
  ["now", "as set now"], ...presets.map((p) => [`preset:${p}`, `accuracy ${p}`]),
  ...effects.map((e) => [`off:${e}`, `without ${words(e).toLowerCase()}`]), ["off:all", "all effects off"],
];

// The same view with such a choice.
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
      $("wipe-start").textContent = this.on ? "Stop wiping" : "Wipe between them";
      if (!this.on) this.hide();
      changed();
    });
  }

  // A picture of the view's truth, or nothing: then nobody can choose it.
  setTruth(path) {
    this.truth = path;
    const right = $("wipe-with"), option = right.querySelector("[value=truth]");
    if (path && !option) right.append(element("option", { value: "truth", textContent: "the traced truth" }));
    if (!path && option) {
      const chosen = right.value === "truth";
      option.remove();
      if (chosen) right.value = "off:all";
    }
  }

  // Fills the right side: with the truth, or with what `draw(request)` comes to.
  async showRight(request, draw) {
    const right = $("wipe-with").value;
    const blob = right === "truth" ? await pictureAt(this.truth) : (await draw(withChoice(request, right))).blob;
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
