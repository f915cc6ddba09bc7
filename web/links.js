// The present view as a link to the image, a link to this page, a curl command or JSON.
import { $ } from "./dom.js";
import { objectOf, propertiesOf, valueOf } from "./schema.js";

const isList = (value) => Array.isArray(value) && value.some((x) => typeof x === "object");

// `name=value` for each field, nested names joined by dots, numbers by commas; lists of objects as JSON.
export function queryOf(request) {
  const pairs = [];
  const walk = (value, name) => {
    if (value === undefined || value === null) return;
    if (isList(value)) {
      pairs.push([name, JSON.stringify(value)]);
    } else if (Array.isArray(value)) {
      if (value.length) pairs.push([name, value.join(",")]);
    } else if (typeof value === "object") {
      for (const [key, inner] of Object.entries(value)) walk(inner, name ? `${name}.${key}` : key);
    } else pairs.push([name, String(value)]);
  };
  walk(request, "");
  return pairs.map(([name, value]) => `${name}=${encodeURIComponent(value).replace(/%2C/g, ",")}`).join("&");
}

// The inverse. Fields that the schema does not have, or of the wrong type, are ignored: the link may be old.
export function requestOf(query, schema) {
  const request = {};
  for (const pair of query.replace(/^[#?]/, "").split("&").filter(Boolean)) {
    const equals = pair.indexOf("=");
    let text;
    try {
      text = decodeURIComponent(pair.slice(equals + 1));
    } catch {
      continue;
    }
    const path = pair.slice(0, equals).split(".");
    let field = schema, into = request;
    for (const name of path.slice(0, -1)) {
      const properties = propertiesOf(field);
      field = Object.hasOwn(properties, name) ? properties[name] : {};
      if (objectOf(field).type === "object") into = into[name] ??= {};
    }
    const last = path.at(-1);
    const properties = propertiesOf(field);
    const value = Object.hasOwn(properties, last) ? valueOf(properties[last], text) : undefined;
    if (value !== undefined && typeof into === "object") into[last] = value;
  }
  return request;
}

export function curlOf(request, base) {
  const body = JSON.stringify(request).replaceAll("'", "'\\''");
  return `curl -s ${base}v1/frames -H 'Content-Type: application/json' -d '${body}' -o frame.jpg`;
}

// Rounds to six significant digits, which are a tenth of a millimetre in a hundred metres.
export function rounded(value) {
  if (typeof value === "number") return Number(value.toPrecision(6));
  if (Array.isArray(value)) return value.map(rounded);
  if (value && typeof value === "object")
    return Object.fromEntries(Object.entries(value).map(([k, v]) => [k, rounded(v)]));
  return value;
}

// ---- sharing ---------------------------------------------------------------------------------

async function copy(text, what) {
  try {
    await navigator.clipboard.writeText(text);
    $("copied").textContent = `Copied ${what}.`;
  } catch {
    $("copied").textContent = text;
  }
}

// Connects the buttons. fullRequest(): the request of the full frame; changed(): renders it again; paths: of the OpenAPI
// document. -> { live() }: the name of the live view, or undefined.
export function connectSharing({ session, fullRequest, changed, paths }) {
  const base = new URL(".", location.href).href;
  $("copy-link").addEventListener("click", () => copy(`${base}#${session.query()}`, "a link to this page and view"));
  $("copy-image-link").addEventListener("click", () => copy(`${base}v1/frames?${queryOf(fullRequest())}`, "a link to the image"));
  $("copy-curl").addEventListener("click", () => copy(curlOf(fullRequest(), base), "the command"));
  $("copy-json").addEventListener("click", () => copy(JSON.stringify(fullRequest(), null, 2), "the request"));

  let live;
  $("live-row").hidden = !paths["/v1/stream"];
  $("live").addEventListener("change", () => {
    live = $("live").checked ? `page-${Math.random().toString(36).slice(2, 8)}` : undefined;
    $("live-words").hidden = !live;
    if (!live) return;
    $("live-link").href = $("live-link").textContent = new URL(`v1/stream?view=${live}`, base).href;
    changed();
  });
  return { live: () => live };
}
