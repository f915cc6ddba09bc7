// The HTTP interface of the server: requests, responses and problems. Paths are relative, so that the page works
// below a path prefix of a proxy.

// A problem document (RFC 9457), or its equivalent if the server did not respond.
export class Problem extends Error {
  constructor({ status = 0, code = "", title = "No response", detail = "", errors = [] }, retryAfterSeconds) {
    super(detail || title);
    Object.assign(this, { status, code, title, detail, errors, retryAfterSeconds });
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
  return new Problem({ ...body, status: response.status }, retryAfter);
}

let token = "";
// For servers that require one: sent with every request from now on.
export const useToken = (value) => { token = value; };

async function request(path, { headers, ...options } = {}) {
  let response;
  try {
    response = await fetch(path, { ...options, headers: { ...headers, ...(token ? { Authorization: `Bearer ${token}` } : {}) } });
    if (!response.ok) throw await problemOf(response);
  } catch (error) {
    if (error instanceof Problem) throw error;
    throw new Problem({ title: "No response", detail: "The server cannot be reached." });
  }
  return response;
}

const send = (method, path, body, signal, headers) => request(path, {
  method, headers: { "Content-Type": "application/json", ...headers }, body: JSON.stringify(body), signal,
});
const post = (path, body, signal, headers) => send("POST", path, body, signal, headers);

export const getJson = async (path) => (await request(path)).json();

// `queue;dur=0.1, surface;desc="surface:main";dur=41.5` -> [{ name, milliseconds }]
export function parseServerTiming(header) {
  return header.split(/,(?=(?:[^"]*"[^"]*")*[^"]*$)/).flatMap((entry) => {
    const [name, ...parameters] = entry.split(";").map((part) => part.trim());
    const duration = parameters.find((p) => p.startsWith("dur="));
    return name && duration ? [{ name, milliseconds: Number(duration.slice(4)) || 0 }] : [];
  });
}

// "revision=2, share=0.50" -> { revision: 2, share: 0.5, failed: false }; undefined for a frame without light between surfaces.
export function lightOf(header) {
  const found = /revision=(\d+), share=([\d.]+)/.exec(header ?? "");
  return found ? { revision: Number(found[1]), share: Number(found[2]), failed: header.endsWith("failed") } : undefined;
}

// Whether the server would draw the light differently now: more of it is complete, or another renderer answers, which has begun
// again. shown: of a frame; now: `light` of its scene.
export const lightChanged = (shown, now) => now?.revision !== shown.revision || (now.share >= 1 && shown.share < 1);

// -> the image as a Blob, with timings and accuracy from the headers; with `explain` also the plan; with explain "maps"
// also the maps that the frame reads: [{ subject, blob }]. headers: further ones of the request.
export async function renderFrame(request, explain = "0", signal = undefined, headers = {}) {
  const start = performance.now();
  const response = await post(`v1/frames${explain === "0" ? "" : `?explain=${explain}`}`, request, signal, headers);
  const bytes = new Uint8Array(await response.arrayBuffer().catch(() => {
    throw new Problem({ title: "No response", detail: "The connection was closed in the middle of the response." });
  }));
  const frame = {
    milliseconds: performance.now() - start,
    timings: parseServerTiming(response.headers.get("Server-Timing") ?? ""),
    accuracy: response.headers.get("Clerestory-Accuracy") ?? "",
    light: lightOf(response.headers.get("Clerestory-Light")),
  };
  const type = response.headers.get("Content-Type") ?? "";
  if (!type.startsWith("multipart/")) return { ...frame, blob: new Blob([bytes], { type }) };
  const [image, explanation, ...maps] = partsOf(type, bytes);
  const plan = JSON.parse(decoder.decode(explanation.bytes));
  const blobOf = (part) => new Blob([part.bytes], { type: part.headers["content-type"] });
  return {
    ...frame,
    blob: blobOf(image),
    plan,
    maps: maps.map((part, i) => ({ subject: plan.maps[i].subject, blob: blobOf(part) })),
  };
}

// The value of one pixel of a channel: metres for `depth`, instance + 1 for `objectId`; 0 for the background.
export async function pixelOf({ scene, camera: { position, target }, time }, intrinsics, channel) {
  const request = { scene, camera: { position, target, intrinsics }, width: 1, height: 1, time,
                    output: { channel, format: "npy" } };
  return floatsOf(await (await post("v1/frames", request)).arrayBuffer())[0];
}

// The instances that a request shows: [{ node, pixels, worldFromModel, … }].
export async function instancesOf(shown) {
  const { instances } = await (await post("v1/frames", { ...shown, output: { channel: "instances", format: "json" } })).json();
  return instances;
}

// Sets the live view that v1/stream?view=NAME shows.
export const putView = (name, request) => send("PUT", `v1/views/${encodeURIComponent(name)}`, request);

// ---- jobs -------------------------------------------------------------------------------------

export const startComparison = async (body) => (await post("v1/comparisons", body)).json();
export const jobOf = (id) => getJson(`v1/jobs/${encodeURIComponent(id)}`);
export const cancelJob = (id) => request(`v1/jobs/${encodeURIComponent(id)}`, { method: "DELETE" });

// A path from the server, relative to the page.
export const relativePath = (path) => path.replace(/^\//, "");
export const imageAt = async (path) => (await request(relativePath(path))).blob();

// Uploads a scene; onProgress(fraction). -> the id of the scene, which may still be loading.
export const uploadScene = (content, title, onProgress) => uploadTo("v1/scenes", content, title, onProgress, {
  "Content-Type": /\.glb$/i.test(title) ? "model/gltf-binary" : "application/octet-stream", Prefer: "respond-async",
});
// Uploads an environment map. -> its name, when it is loaded.
export const uploadMap = (content, title, onProgress) => uploadTo("v1/environments", content, title, onProgress, {
  "Content-Type": "application/octet-stream",
});

// -> the last part of the Location. Uses XMLHttpRequest, because fetch() does not report upload progress.
function uploadTo(path, content, title, onProgress, headers) {
  return new Promise((resolve, reject) => {
    const upload = new XMLHttpRequest();
    upload.open("POST", `${path}?title=${encodeURIComponent(title)}`);
    for (const [name, value] of Object.entries(headers)) upload.setRequestHeader(name, value);
    if (token) upload.setRequestHeader("Authorization", `Bearer ${token}`);
    upload.upload.addEventListener("progress", (e) => onProgress(e.lengthComputable ? e.loaded / e.total : undefined));
    upload.addEventListener("error", () => reject(new Problem({ title: "No response", detail: "The server cannot be reached." })));
    upload.addEventListener("load", async () => {
      const { status, statusText } = upload;
      const retry = { "Retry-After": upload.getResponseHeader("Retry-After") ?? "" };
      if (status >= 300) return reject(await problemOf(new Response(upload.responseText, { status, statusText, headers: retry })));
      const location = upload.getResponseHeader("Location");
      resolve(decodeURIComponent(location.slice(location.lastIndexOf("/") + 1)));
    });
    upload.send(content);
  });
}

// ---- response formats ------------------------------------------------------------------------

const decoder = new TextDecoder();

function indexOf(bytes, pattern, from) {
  for (let i = from; i + pattern.length <= bytes.length; ++i) {
    let k = 0;
    while (k < pattern.length && bytes[i + k] === pattern.charCodeAt(k)) ++k;
    if (k === pattern.length) return i;
  }
  return -1;
}

// The parts of a multipart body, each of which has a Content-Length. -> [{ headers: { "content-type": … }, bytes }]
export function partsOf(contentType, bytes) {
  const boundary = /boundary="?([^";]+)"?/.exec(contentType)?.[1];
  if (!boundary) throw new Error(`no boundary in ${contentType}`);
  const parts = [];
  for (let at = 0; ;) {
    at = indexOf(bytes, `--${boundary}`, at);
    if (at < 0) break;
    const head = at + boundary.length + 4;
    const end = indexOf(bytes, "\r\n\r\n", head);
    if (end < 0) break;
    const headers = Object.fromEntries(decoder.decode(bytes.subarray(head, end)).split("\r\n").map((line) => {
      const colon = line.indexOf(":");
      return [line.slice(0, colon).toLowerCase(), line.slice(colon + 1).trim()];
    }));
    const length = Number(headers["content-length"]);
    if (!Number.isInteger(length)) throw new Error("a part has no Content-Length");
    parts.push({ headers, bytes: bytes.subarray(end + 4, end + 4 + length) });
    at = end + 4 + length;
  }
  return parts;
}

// The values of a little-endian float32 NPY file, version 1, in the order of the file.
export function floatsOf(buffer) {
  const view = new DataView(buffer);
  if (view.getUint8(0) !== 0x93 || decoder.decode(buffer.slice(1, 6)) !== "NUMPY") throw new Error("not an NPY file");
  const start = 10 + view.getUint16(8, true);
  if (!decoder.decode(buffer.slice(10, start)).includes("'<f4'")) throw new Error("not float32");
  return Array.from({ length: (buffer.byteLength - start) / 4 }, (_, i) => view.getFloat32(start + 4 * i, true));
}
