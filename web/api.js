// The server's HTTP interface as the page uses it: requests, answers, problems, links.

// A problem document (RFC 9457), or its like for a server that did not answer.
export class Problem extends Error {
  constructor({ status = 0, title = "No answer", detail = "", errors = [] }, retryAfterSeconds) {
    super(detail || title);
    Object.assign(this, { status, title, detail, errors, retryAfterSeconds });
  }
}

async function problemOf(response) {
  const retryAfter = Number(response.headers.get("Retry-After")) || undefined;
  const text = await response.text();
  let body;
  try {
    body = JSON.parse(text);
  } catch {
    body = { title: response.statusText || "Error", detail: text.slice(0, 300) };
  }
  return new Problem({ status: response.status, ...body }, retryAfter);
}

async function ask(path, options) {
  let response;
  try {
    response = await fetch(path, options);
  } catch {
    throw new Problem({ title: "No answer", detail: "The server cannot be reached." });
  }
  if (!response.ok) throw await problemOf(response);
  return response;
}

export const getJson = async (path) => (await ask(path)).json();

// -> the picture as a Blob, with what the headers tell about it.
export async function renderFrame(request) {
  const start = performance.now();
  const response = await ask("v1/frames", {
    method: "POST",
    headers: { "Content-Type": "application/json" },
    body: JSON.stringify(request),
  });
  const blob = await response.blob();
  return {
    blob,
    milliseconds: performance.now() - start,
    timings: parseServerTiming(response.headers.get("Server-Timing") ?? ""),
    passes: (response.headers.get("Clerestory-Passes") ?? "").split(",").map((s) => s.trim()).filter(Boolean),
  };
}

// What the same request would take, decisions and all; draws nothing.
export const planOf = async (request) => (await ask("v1/plans", {
  method: "POST",
  headers: { "Content-Type": "application/json" },
  body: JSON.stringify(request),
})).json();

const kMethods = {
  environment: "environment map", probe: "captured cube", mirror: "mirrored pass",
  backdrop: "picture behind it", traced: "traced rays",
};

// { name: "mirror:floor", taken: "mirror", reason: "12 % of the frame" } -> "floor: mirrored pass, 12 % of the frame"
export const decisionText = ({ name, taken, reason }) =>
  `${name.slice(name.indexOf(":") + 1)}: ${kMethods[taken] ?? taken}, ${reason}`;

// `queue;dur=0.1, surface;desc="surface:main";dur=41.5` -> [{ name, milliseconds }]
export function parseServerTiming(header) {
  return header.split(/,(?=(?:[^"]*"[^"]*")*[^"]*$)/).flatMap((entry) => {
    const [name, ...parameters] = entry.split(";").map((part) => part.trim());
    const duration = parameters.find((p) => p.startsWith("dur="));
    return name && duration ? [{ name, milliseconds: Number(duration.slice(4)) || 0 }] : [];
  });
}

// The same request as a link: one `name=value` per field, nested names joined by dots, lists by commas.
export function queryOf(request) {
  const pairs = [];
  const walk = (value, name) => {
    if (value === undefined || value === null) return;
    if (Array.isArray(value)) pairs.push([name, value.join(",")]);
    else if (typeof value === "object") {
      for (const [key, inner] of Object.entries(value)) walk(inner, name ? `${name}.${key}` : key);
    } else pairs.push([name, String(value)]);
  };
  walk(request, "");
  return pairs.map(([name, value]) => `${name}=${encodeURIComponent(value).replace(/%2C/g, ",")}`).join("&");
}

export function curlOf(request, origin) {
  const body = JSON.stringify(request).replaceAll("'", "'\\''");
  return `curl -s ${origin}/v1/frames -H 'Content-Type: application/json' -d '${body}' -o frame.jpg`;
}

// Short enough to share: six significant digits are a tenth of a millimetre in a hundred metres.
export function rounded(value) {
  if (typeof value === "number") return Number(value.toPrecision(6));
  if (Array.isArray(value)) return value.map(rounded);
  if (value && typeof value === "object")
    return Object.fromEntries(Object.entries(value).map(([k, v]) => [k, rounded(v)]));
  return value;
}
