// Creates and finds elements. Style attributes are not used, because the Content-Security-Policy forbids them.

export const $ = (id) => document.getElementById(id);

export function element(tag, attributes = {}, ...children) {
  const created = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (value === undefined) continue;
    if (name.startsWith("on")) created.addEventListener(name.slice(2), value);
    else if (name in created && name !== "list") created[name] = value;
    else created.setAttribute(name, value);
  }
  created.append(...children.filter((child) => child !== undefined && child !== ""));
  return created;
}

export function svg(tag, attributes = {}, ...children) {
  const created = document.createElementNS("http://www.w3.org/2000/svg", tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith("on")) created.addEventListener(name.slice(2), value);
    else created.setAttribute(name, value);
  }
  created.append(...children);
  return created;
}

export function fillSelect(select, options, value) {
  select.replaceChildren(...options.map(([key, label]) => element("option", { value: key, textContent: label })));
  select.value = value;
}

// A segmented control made of radio buttons. `changed` is called with the selected word.
export function segments(parent, name, words, value, changed) {
  parent.replaceChildren(...words.map((word) => {
    const input = element("input", { type: "radio", name, value: word, checked: word === value,
                                     onchange: () => changed(word) });
    return element("label", {}, input, element("span", {}, word));
  }));
}

// Shows a Blob in an <img>; the URL of the previous one is revoked after that.
const shown = new WeakMap();
export async function showBlob(image, blob) {
  const url = URL.createObjectURL(blob);
  image.src = url;
  await image.decode().catch(() => {});
  URL.revokeObjectURL(shown.get(image));
  shown.set(image, url);
}

// Tabs with keyboard navigation, as in the WAI-ARIA pattern.
export function tabs(list, opened) {
  const all = [...list.querySelectorAll("[role=tab]")];
  const open = (tab) => {
    for (const other of all) {
      other.setAttribute("aria-selected", other === tab);
      other.tabIndex = other === tab ? 0 : -1;
      $(other.getAttribute("aria-controls")).hidden = other !== tab;
    }
    opened(tab.id);
  };
  list.addEventListener("click", (e) => e.target.role === "tab" && open(e.target));
  list.addEventListener("keydown", (e) => {
    const at = all.indexOf(document.activeElement);
    const next = { ArrowRight: at + 1, ArrowLeft: at - 1, Home: 0, End: all.length - 1 }[e.key];
    if (next === undefined || at < 0) return;
    e.preventDefault();
    const tab = all[(next + all.length) % all.length];
    tab.focus();
    open(tab);
  });
}
