// Form controls that are generated from the schema of the server; schema.js determines their kind.
import { $, element, fillSelect } from "./dom.js";
import { controlOf, fieldsOfType, labelOf, newOfType, positionFor, sliderSteps, typesOf, valueAt } from "./schema.js";

// Tool tips: while the pointer is over an element with a title, or it has the focus, the line below the settings shows it,
// which touch and keyboards reach too. Screen readers read the title as the description.
export function connectTips() {
  const show = ({ target }) => {
    const tip = target.closest?.("[title]")?.title;
    if (tip) $("hint").textContent = tip;
  };
  for (const event of ["pointerover", "focusin"]) document.addEventListener(event, show);
}

const tipOf = (label, { description, "x-unit": unit }) =>
  (description ? `${description[0].toUpperCase()}${description.slice(1)}${unit ? `, in ${unit}` : ""}.` : `${label}.`);

// Tips of the choice of a segmented control: its radio buttons and what is seen of them.
export function tipSegments(parent, tip) {
  for (const part of parent.querySelectorAll("label, input")) part.title = tip;
}

let count = 0;
const newId = (name) => `field-${name}-${++count}`;

function switchFor(id, value, changed) {
  const input = element("input", { id, type: "checkbox", checked: value === true, onchange: () => changed(input.checked) });
  input.setAttribute("role", "switch");
  return [input];
}

function choiceFor(id, { words, titles = words }, value, changed, none) {
  const select = element("select", { id, onchange: () => changed(select.value === "" ? undefined : select.value) });
  fillSelect(select, [...(none ? [["", none]] : []), ...words.map((w, i) => [w, titles[i]])], value ?? "");
  return [select];
}

function rangeFor(id, label, control, value, changed, none) {
  const number = element("input", {
    id, type: "number", min: control.allowed[0], max: control.allowed[1], step: control.whole ? 1 : "any",
    placeholder: none, onchange: () => {
      if (!number.reportValidity()) return;
      const given = number.value === "" ? undefined : Number(number.value);
      place(given);
      changed(given);
    },
  });
  number.value = value ?? "";
  const slider = element("input", {
    type: "range", min: 0, max: sliderSteps(control), step: 1, oninput: () => {
      number.value = valueAt(control, Number(slider.value));
      show(Number(number.value));
      changed(Number(number.value));
    },
  });
  slider.setAttribute("aria-label", `${label}, slider`);
  // An omitted field has the middle of the slider, dimmed.
  const show = (now) => {
    slider.classList.toggle("unset", now === undefined);
    slider.setAttribute("aria-valuetext", now ?? none ?? "none");
  };
  const place = (now) => {
    slider.value = now === undefined ? Math.round(sliderSteps(control) / 2) : positionFor(control, now);
    show(now);
  };
  place(value);
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
// if the field is omitted. `none` is the name of that choice. sliderRange: [min, max] of the slider, within the allowed range.
export function controlFor(name, schema, value, changed, { none, sliderRange } = {}) {
  const control = controlOf(name, schema, sliderRange);
  const id = newId(name), label = labelOf(name);
  const inputs = {
    switch: () => switchFor(id, value, changed),
    choice: () => choiceFor(id, control, value, changed, none),
    range: () => rangeFor(id, label, control, value, changed, none),
    text: () => textFor(id, value, changed, control.maxLength),
    vector: () => vectorFor(id, label, control.count, value, changed),
  }[control.kind]?.();
  if (!inputs) return undefined;
  const row = element("div", { className: `field ${control.kind}` },
                      element("label", { htmlFor: id }, label), ...inputs);
  row.dataset.field = name;
  for (const part of [row, ...row.querySelectorAll("input, select")]) part.title = tipOf(label, schema);
  return row;
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
    made.title = { Earlier: "Applies this filter before the one above", Remove: "Removes this filter" }[words];
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
