// Form controls made from the server's own schema (/openapi.json), so that a field the server gains
// gets its control here without a line of code.

// Where the sensible stretch is shorter than the allowed one.
const kSliders = { exposure: [-6, 6, 0.25], intensity: [0, 4, 0.05] };

// planarReflection -> Planar reflection
export const wordsOf = (name) => {
  const words = name.replace(/([A-Z])/g, (c) => ` ${c.toLowerCase()}`);
  return words[0].toUpperCase() + words.slice(1);
};

export function element(tag, attributes = {}, ...children) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith("on")) made.addEventListener(name.slice(2), value);
    else if (name in made && name !== "list") made[name] = value;
    else made.setAttribute(name, value);
  }
  made.append(...children);
  return made;
}

export function fillSelect(select, options, value) {
  select.replaceChildren(...options.map(([key, label]) => element("option", { value: key, textContent: label })));
  select.value = value;
}

// A labelled control for one field. `changed` gets the new value, or undefined for "leave it to the
// preset" where `optional` is set.
export function controlFor(name, schema, value, changed, { optional = false } = {}) {
  const id = `field-${name}`;
  const title = schema.description ?? "";
  const label = element("label", { htmlFor: id, title }, wordsOf(name));
  if (schema.type === "boolean" && !optional) {
    const input = element("input", {
      id, type: "checkbox", checked: value, title, onchange: () => changed(input.checked),
    });
    input.setAttribute("role", "switch");
    return element("div", { className: "field switch" }, label, input);
  }
  if (schema.type === "boolean" || schema.enum) {
    const words = schema.enum ?? ["true", "false"];
    const select = element("select", { id, title, onchange: () => {
      if (select.value === "") changed(undefined);
      else changed(schema.enum ? select.value : select.value === "true");
    } });
    const label2 = (word) => (schema.enum ? word : word === "true" ? "on" : "off");
    fillSelect(select, [...(optional ? [["", "preset"]] : []), ...words.map((w) => [w, label2(w)])],
               value === undefined ? "" : String(value));
    return element("div", { className: "field" }, label, select);
  }
  if (kSliders[name]) {
    const [min, max, step] = kSliders[name];
    const shown = element("output", { htmlFor: id, textContent: value });
    const input = element("input", { id, type: "range", min, max, step, title, oninput: () => {
      shown.textContent = input.value;
      changed(Number(input.value));
    } });
    input.value = value;
    return element("div", { className: "field slider" }, label, input, shown);
  }
  const input = element("input", {
    id, type: "number", min: schema.minimum ?? "", max: schema.maximum ?? "", title,
    step: schema.type === "integer" ? 1 : "any", placeholder: optional ? "preset" : "",
    onchange: () => {
      if (!input.reportValidity()) return;
      changed(input.value === "" ? undefined : Number(input.value));
    },
  });
  input.value = value ?? "";
  return element("div", { className: "field" }, label, input);
}

// One control a property, into `parent`. `values` is read now and written on every change.
export function controlsFor(parent, properties, values, changed, options = {}) {
  parent.replaceChildren(...Object.entries(properties).map(([name, schema]) =>
    controlFor(name, schema, values[name] ?? (options.optional ? undefined : schema.default), (value) => {
      if (value === undefined) delete values[name];
      else values[name] = value;
      changed();
    }, options)));
}
