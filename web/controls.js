// Form controls made from the server's schema; schema.js says what each needs.
import { $, element, fillSelect } from "./dom.js";
import { controlOf, positionFor, sliderSteps, valueAt, wordsOf } from "./schema.js";

// What a field means is shown in one quiet place while it is pointed at or has the focus.
function explains(row, words) {
  if (!words) return row;
  const tell = () => { $("hint").textContent = `${words[0].toUpperCase()}${words.slice(1)}.`; };
  row.addEventListener("pointerenter", tell);
  row.addEventListener("focusin", tell);
  return row;
}

let made = 0;
const newId = (name) => `field-${name}-${++made}`;

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

function rangeFor(id, words, control, value, changed, none) {
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
  slider.setAttribute("aria-label", `${words}, slider`);
  slider.value = value === undefined ? 0 : positionFor(control, value);
  return [slider, number];
}

function textFor(id, value, changed, most) {
  const input = element("input", { id, type: "text", maxLength: most, onchange: () => changed(input.value || undefined) });
  input.value = value ?? "";
  return [input];
}

function vectorFor(id, words, count, value, changed) {
  const inputs = Array.from({ length: count }, (_, i) => {
    const input = element("input", { id: i === 0 ? id : undefined, type: "number", step: "any", onchange: () => {
      const all = inputs.map((x) => Number(x.value));
      if (inputs.every((x) => x.value !== "") && all.every(Number.isFinite)) changed(all);
    } });
    input.setAttribute("aria-label", `${words}, number ${i + 1} of ${count}`);
    input.value = value?.[i] ?? "";
    return input;
  });
  return [element("span", { className: "vector" }, ...inputs)];
}

// A labelled control for one field, or nothing for a field of objects. `changed` gets the new value;
// undefined says "as if it were left out", which `none` gives a name to where that is a choice.
export function controlFor(name, schema, value, changed, { none } = {}) {
  const control = controlOf(name, schema);
  const id = newId(name), words = wordsOf(name);
  const inputs = {
    switch: () => switchFor(id, value, changed),
    choice: () => choiceFor(id, control.words, value, changed, none),
    range: () => rangeFor(id, words, control, value, changed, none),
    text: () => textFor(id, value, changed, control.most),
    vector: () => vectorFor(id, words, control.count, value, changed),
  }[control.kind]?.();
  if (!inputs) return undefined;
  const row = element("div", { className: `field ${control.kind}` },
                      element("label", { htmlFor: id, title: schema.description ?? "" }, words), ...inputs);
  row.dataset.field = name;
  return explains(row, schema.description);
}

// One control a field, into `parent`; `values` is read now and written on every change. nones: what to call
// "left out", by field.
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
