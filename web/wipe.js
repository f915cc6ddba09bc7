// The same view with two settings, one to the left of a line and one to the right of it.
import { $, fillSelect } from "./dom.js";

// What the wipe may show on either side: [key, words]. effects: their names.
export const wipeChoices = (presets, effects, words) => [
  ["now", "as set now"], ...presets.map((p) => [`preset:${p}`, `accuracy ${p}`]),
  ...effects.map((e) => [`off:${e}`, `without ${words(e).toLowerCase()}`]), ["off:all", "without any effect"],
];

// The same view with such a choice.
export function withChoice(request, key) {
  const [kind, what] = key.split(":");
  if (kind === "preset") return { ...request, accuracy: what };
  if (kind !== "off") return request;
  const effects = Object.fromEntries(Object.entries(request.effects).map(([name, on]) => [name, on && what !== "all" && name !== what]));
  return { ...request, effects };
}

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

  left(request) {
    return this.on ? withChoice(request, $("before").value) : request;
  }
  right(request) {
    return withChoice(request, $("wipe-with").value);
  }

  hide() {
    for (const id of ["after", "wipe", "wipe-line", "tag-before", "tag-after"]) $(id).hidden = true;
  }
  show() {
    for (const id of ["after", "wipe", "wipe-line", "tag-before", "tag-after"]) $(id).hidden = false;
    $("tag-before").textContent = $("before").selectedOptions[0].textContent;
    $("tag-after").textContent = $("wipe-with").selectedOptions[0].textContent;
  }
}
