// The list of filters on the finished picture: its kinds and their fields come from the schema.
import { $, element, fillSelect } from "./dom.js";
import { controlFor } from "./controls.js";
import { controlOf, fieldsOfType, newOfType, typesOf, wordsOf } from "./schema.js";

export function filtersPart(session, schema, changed) {
  const item = schema.items;
  const draw = () => $("filters").replaceChildren(...session.filters.map((filter, i) => {
    const named = element("div", { className: "split" }, element("b", {}, wordsOf(filter.type)),
      element("span", {},
        button("Earlier", "↑", i > 0, () => session.filters.splice(i - 1, 2, filter, session.filters[i - 1])),
        button("Remove", "×", true, () => session.filters.splice(i, 1))));
    const fields = Object.entries(fieldsOfType(item, filter.type)).flatMap(([name, field]) =>
      controlFor(name, field, filter[name] ?? field.default, (value) => {
        if (value === undefined) delete filter[name];
        else filter[name] = value;
        changed();
      }, { none: field.default === undefined && filter[name] === undefined ? "none" : undefined }) ?? []);
    return element("li", {}, named, ...fields);
  }));
  const button = (words, sign, enabled, act) => {
    const made = element("button", { type: "button", className: "plain", disabled: !enabled, textContent: sign, onclick: () => {
      act();
      draw();
      changed();
    } });
    made.setAttribute("aria-label", words);
    return made;
  };
  fillSelect($("add-filter"), [["", "choose…"], ...typesOf(item).map((t) => [t, wordsOf(t)])], "");
  $("add-filter").addEventListener("change", () => {
    session.filters.push(newOfType(item, $("add-filter").value));
    $("add-filter").value = "";
    draw();
    changed();
  });
  $("filters-part").hidden = false;
  draw();
}
