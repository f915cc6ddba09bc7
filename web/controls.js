// Form controls that are generated from the schema of the server; schema.js determines their kind.
import { $, element, fillSelect } from "./dom.js";
import { controlOf, fieldsOfType, labelOf, newOfType, positionFor, sliderSteps, typesOf, valueAt } from "./schema.js";

// Shows the description of a field and its unit while the pointer is over it or it has the focus.
function withHint(row, { description, "x-unit": unit }) {
  if (!description) return row;
  const text = `${description[0].toUpperCase()}${description.slice(1)}${unit ? `, in ${unit}` : ""}.`;
  const show = () => { $("hint").textContent = text; };
  row.addEventListener("pointerenter", show);
  row.addEventListener("focusin", show);
  return row;
}

let count = 0;
const newId = (name) => `field-${name}-${++count}`;

function switchFor(id, value, changed) {
  const input = element("input", { id, type: "checkbox", checked: value === true, onchange: () => changed(input.checked) });
  input.setAttribute("role", "switch");
  return [input];
}

function choiceFor(id, words, value, changed, none) {
  const select = element("select", { id, onchange: () => changed(select.value === "" ? undefined : select.value) });
  fillSelect(select, [...(none ? [["", none]] : []), ...words.map((w) => [w, w])], value ?? "");
  return [select];
}

function rangeFor(id, label, control, value, changed, none) {
  const number = element("input", {
    id, type: "number", min: control.allowed[0], max: control.allowed[1], step: control.whole ? 1 : "any",
    placeholder: none, onchange: () => {
      if (!number.reportValidity()) return;
      const given = number.value === "" ? undefined : Number(number.value);
      if (given !== undefined) slider.value = positionFor(control, given);
      changed(given);
    },
  });
  number.value = value ?? "";
  const slider = element("input", {
    type: "range", min: 0, max: sliderSteps(control), step: 1, oninput: () => {
      number.value = valueAt(control, Number(slider.value));
      changed(Number(number.value));
    },
  });
  slider.setAttribute("aria-label", `${label}, slider`);
  slider.value = value === undefined ? 0 : positionFor(control, value);
  return [slider, number];
}

function textFor(id, value, changed, maxLength) {
  const input = element("input", { id, type: "text", maxLength, onchange: () => changed(input.value || undefined) });
  input.value = value ?? "";
  return [input];
}

function vectorFor(id, label, count, value, changed) {
  const inputs = Array.from({ length: count }, (_, i) => {
    const input = element("input", { id: i === 0 ? id : undefined, type: "number", step: "any", onchange: () => {
      const all = inputs.map((x) => Number(x.value));
      if (inputs.every((x) => x.value !== "") && all.every(Number.isFinite)) changed(all);
    } });
    input.setAttribute("aria-label", `${label}, number ${i + 1} of ${count}`);
    input.value = value?.[i] ?? "";
    return input;
  });
  return [element("span", { className: "vector" }, ...inputs)];
}

// A labelled control for one field, or nothing for a field of objects. `changed` is called with the new value, undefined
// if the field is omitted. `none` is the name of that choice.
export function controlFor(name, schema, value, changed, { none } = {}) {
  const control = controlOf(name, schema);
  const id = newId(name), label = labelOf(name);
  const inputs = {
    switch: () => switchFor(id, value, changed),
    choice: () => choiceFor(id, control.words, value, changed, none),
    range: () => rangeFor(id, label, control, value, changed, none),
    text: () => textFor(id, value, changed, control.maxLength),
    vector: () => vectorFor(id, label, control.count, value, changed),
  }[control.kind]?.();
  if (!inputs) return undefined;
  const row = element("div", { className: `field ${control.kind}` },
                      element("label", { htmlFor: id, title: schema.description ?? "" }, label), ...inputs);
  row.dataset.field = name;
  return withHint(row, schema);
}

// A control for each field in `parent`. `values` is updated on every change. nones: the name of "omitted", by field.
export function controlsFor(parent, schemas, values, changed, nones = {}) {
  parent.replaceChildren(...Object.entries(schemas).flatMap(([name, schema]) => {
    const none = nones[name] ?? (schema.default === undefined && schema.type !== "boolean" ? "none" : undefined);
    return controlFor(name, schema, values[name], (value) => {
      if (value === undefined) delete values[name];
      else values[name] = value;
      changed();
    }, { none }) ?? [];
  }));
}

// The list of filters of the image.
export function filterControls(session, schema, changed) {
  const item = schema.items;
  const draw = () => $("filters").replaceChildren(...session.filters.map((filter, i) => {
    const named = element("div", { className: "split" }, element("b", {}, labelOf(filter.type)),
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
  fillSelect($("add-filter"), [["", "choose…"], ...typesOf(item).map((t) => [t, labelOf(t)])], "");
  $("add-filter").addEventListener("change", () => {
    session.filters.push(newOfType(item, $("add-filter").value));
    $("add-filter").value = "";
    draw();
    changed();
  });
  $("filters-part").hidden = false;
  draw();
}
