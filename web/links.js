// One view in all the forms in which people carry it away: a link to the picture, a link to this page,
// a curl command, JSON. Pure.
import { objectOf, valueOf } from "./schema.js";

const isList = (value) => Array.isArray(value) && value.some((x) => typeof x === "object");

// `name=value` per field, nested names joined by dots, numbers by commas. Lists of objects have no
// place in a link of the API; where `lists` is set they go as JSON.
export function queryOf(request, { lists = false } = {}) {
  const pairs = [];
  const walk = (value, name) => {
    if (value === undefined || value === null) return;
    if (isList(value)) {
      if (lists) pairs.push([name, JSON.stringify(value)]);
    } else if (Array.isArray(value)) {
      if (value.length) pairs.push([name, value.join(",")]);
    } else if (typeof value === "object") {
      for (const [key, inner] of Object.entries(value)) walk(inner, name ? `${name}.${key}` : key);
    } else pairs.push([name, String(value)]);
  };
  walk(request, "");
  return pairs.map(([name, value]) => `${name}=${encodeURIComponent(value).replace(/%2C/g, ",")}`).join("&");
}

// The other way round. What the schema does not know or cannot hold is left out: a link may be old.
export function requestOf(query, schema) {
  const request = {};
  for (const pair of query.replace(/^[#?]/, "").split("&").filter(Boolean)) {
    const cut = pair.indexOf("=");
    let text;
    try {
      text = decodeURIComponent(pair.slice(cut + 1));
    } catch {
      continue;
    }
    const path = pair.slice(0, cut).split(".");
    let field = schema, into = request;
    for (const name of path.slice(0, -1)) {
      field = Object.hasOwn(objectOf(field).properties ?? {}, name) ? objectOf(field).properties[name] : {};
      if (objectOf(field).type === "object") into = into[name] ??= {};
    }
    const last = path.at(-1);
    const properties = objectOf(field).properties ?? {};
    const value = Object.hasOwn(properties, last) ? valueOf(properties[last], text) : undefined;
    if (value !== undefined && typeof into === "object") into[last] = value;
  }
  return request;
}

export function curlOf(request, base) {
  const body = JSON.stringify(request).replaceAll("'", "'\\''");
  return `curl -s ${base}v1/frames -H 'Content-Type: application/json' -d '${body}' -o frame.jpg`;
}

// Short enough to share: six significant digits are a tenth of a millimetre in a hundred metres.
export function rounded(value) {
  if (typeof value === "number") return Number(value.toPrecision(6));
  if (Array.isArray(value)) return value.map(rounded);
  if (value && typeof value === "object")
    return Object.fromEntries(Object.entries(value).map(([k, v]) => [k, rounded(v)]));
  return value;
}
