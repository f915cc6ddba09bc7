// The server's HTTP interface as the page uses it: requests, answers, problems. Paths are relative, so
// that the page also works below a prefix of a proxy.
import { floatsOf, partsOf } from "./bytes.js";

// A problem document (RFC 9457), or its like for a server that did not answer.
export class Problem extends Error {
  constructor({ status = 0, code = "", title = "No answer", detail = "", errors = [] }, retryAfterSeconds) {
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
// For servers that ask for one: goes with every request from now on.
export const useToken = (given) => { token = given; };

async function ask(path, { headers, ...options } = {}) {
  let response;
  try {
    response = await fetch(path, { ...options, headers: { ...headers, ...(token ? { Authorization: `Bearer ${token}` } : {}) } });
    if (!response.ok) throw await problemOf(response);
  } catch (error) {
    if (error instanceof Problem) throw error;
    throw new Problem({ title: "No answer", detail: "The server cannot be reached." });
  }
  return response;
}

const send = (method, path, body, signal) => ask(path, {
  method, headers: { "Content-Type": "application/json" }, body: JSON.stringify(body), signal,
});
const post = (path, body, signal) => send("POST", path, body, signal);

export const getJson = async (path) => (await ask(path)).json();
export const planOf = async (request) => (await post("v1/plans", request)).json();

// `queue;dur=0.1, surface;desc="surface:main";dur=41.5` -> [{ name, milliseconds }]
export function parseServerTiming(header) {
  return header.split(/,(?=(?:[^"]*"[^"]*")*[^"]*$)/).flatMap((entry) => {
    const [name, ...parameters] = entry.split(";").map((part) => part.trim());
    const duration = parameters.find((p) => p.startsWith("dur="));
    return name && duration ? [{ name, milliseconds: Number(duration.slice(4)) || 0 }] : [];
  });
}

// -> the picture as a Blob; what the headers tell about it; with `explain` the plan that ran, and the maps
// behind it where it is "maps": [{ name, blob }].
export async function renderFrame(request, explain = "0", signal = undefined) {
  const start = performance.now();
  const response = await post(`v1/frames${explain === "0" ? "" : `?explain=${explain}`}`, request, signal);
  const bytes = new Uint8Array(await response.arrayBuffer().catch(() => {
    throw new Problem({ title: "No answer", detail: "The answer broke off." });
  }));
  const frame = {
    milliseconds: performance.now() - start,
    timings: parseServerTiming(response.headers.get("Server-Timing") ?? ""),
    accuracy: response.headers.get("Clerestory-Accuracy") ?? "",
  };
  const type = response.headers.get("Content-Type") ?? "";
  if (!type.startsWith("multipart/")) return { ...frame, blob: new Blob([bytes], { type }) };
  const [picture, plan, ...maps] = partsOf(type, bytes);
  const blobOf = (part) => new Blob([part.bytes], { type: part.headers["content-type"] });
  return {
    ...frame,
    blob: blobOf(picture),
    plan: JSON.parse(new TextDecoder().decode(plan.bytes)),
    maps: maps.map((part) => ({ name: /name="([^"]*)"/.exec(part.headers["content-disposition"])?.[1] ?? "", blob: blobOf(part) })),
  };
}

// One pixel's number of a channel: metres for `depth`, instance + 1 for `objectId`; 0 where nothing is.
export async function pixelOf({ scene, camera: { position, target }, time }, intrinsics, channel) {
  const request = { scene, camera: { position, target, intrinsics }, width: 1, height: 1, time,
                    output: { channel, format: "npy" } };
  return floatsOf(await (await post("v1/frames", request)).arrayBuffer())[0];
}

// Moves a view that others watch as v1/stream?view=NAME.
export const putView = (name, request) => send("PUT", `v1/views/${encodeURIComponent(name)}`, request);

// ---- long work --------------------------------------------------------------------------------

export const startComparison = async (body) => (await post("v1/comparisons", body)).json();
export const jobOf = (id) => getJson(`v1/jobs/${encodeURIComponent(id)}`);
export const cancelJob = (id) => ask(`v1/jobs/${encodeURIComponent(id)}`, { method: "DELETE" });

// A path that the server tells, below wherever the page itself lies.
export const below = (path) => path.replace(/^\//, "");
export const pictureAt = async (path) => (await ask(below(path))).blob();

// Sends a scene's file as the body; told(share) says how much of it is there. -> the new scene's id, which
// may still be loading. By XMLHttpRequest, since fetch() does not tell how much it has sent.
export function uploadScene(file, told) {
  const type = /\.glb$/i.test(file.name) ? "model/gltf-binary" : "application/octet-stream";
  return new Promise((resolve, reject) => {
    const request = new XMLHttpRequest();
    request.open("POST", `v1/scenes?title=${encodeURIComponent(file.name)}`);
    request.setRequestHeader("Content-Type", type);
    request.setRequestHeader("Prefer", "respond-async");
    if (token) request.setRequestHeader("Authorization", `Bearer ${token}`);
    request.upload.addEventListener("progress", (e) => told(e.lengthComputable ? e.loaded / e.total : undefined));
    request.addEventListener("error", () => reject(new Problem({ title: "No answer", detail: "The server cannot be reached." })));
    request.addEventListener("load", async () => {
      const { status, statusText } = request;
      const headers = { "Retry-After": request.getResponseHeader("Retry-After") ?? "" };
      if (status >= 300) return reject(await problemOf(new Response(request.responseText, { status, statusText, headers })));
      const place = request.getResponseHeader("Location");
      resolve(decodeURIComponent(place.slice(place.lastIndexOf("/") + 1)));
    });
    request.send(file);
  });
}
