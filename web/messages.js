// Texts of the page: problems, techniques, passes and units; and the message over the image.
import { $ } from "./dom.js";
import { labelOf } from "./schema.js";

// ---- texts -----------------------------------------------------------------------------------

const fieldText = ({ pointer, detail, allowed }) =>
  `${pointer || "The request"} ${detail}${allowed ? ` (allowed: ${allowed})` : ""}`;

// -> { title, lines, retry }: whether a later retry may succeed without any action.
export function messageOf({ status, code, title, detail, errors = [] }) {
  switch (status) {
    case 0:
      return { title: "The server does not respond", lines: ["It may be restarting, or the network may be down."], retry: true };
    case 401:
    case 403:
      return { title: "Access denied", lines: [detail], retry: false };
    case 409:
      return { title, lines: [detail], retry: true };
    case 429:
      return { title: "Too many requests", lines: ["The server limits the rate of requests."], retry: true };
    case 502:
      return { title: "The server is unavailable", lines: ["The proxy received no response from it; it may be restarting."], retry: true };
    case 503:
      return code === "shuttingDown"
        ? { title: "The server is shutting down", lines: ["The page continues when it has restarted."], retry: true }
        : { title: "The server is busy", lines: [detail], retry: true };
    case 504:
      return { title: "This frame takes too long", lines: [detail, "Choose a cheaper accuracy or fewer pixels."], retry: false };
    case 400:
    case 422:
      return { title: "The request is invalid", lines: errors.length ? errors.map(fieldText) : [detail], retry: false };
    default:
      return { title: `${title} (${status})`, lines: [detail], retry: false };
  }
}

// In one line.
export function messageText(problem) {
  const { title, lines } = messageOf(problem);
  return [title, ...lines].join(". ");
}

const kTechniques = {
  environment: "environment map", probe: "captured cube", mirror: "mirrored view",
  backdrop: "backdrop", traced: "ray traced", shadowMap: "shadow map", unshadowed: "no shadow",
};
export const techniqueText = (method) => kTechniques[method] ?? method;

const kEffects = {
  base: "The view", emission: "Emission", refraction: "Refraction", planarReflection: "Planar reflection",
  environmentReflection: "Environment reflection", materialLayers: "Material layers", shadows: "Shadows", indirectLight: "Light between surfaces", filters: "Filters",
};
export const effectText = (effect) => kEffects[effect] ?? labelOf(effect ?? "other");

const kKinds = {
  environment: "environment map", prefilter: "roughness levels", levels: "mip levels", capture: "cube faces", blended: "blended surfaces",
  mirror: "mirrored view", shadow: "shadows of lights", surface: "surfaces", backFaces: "back faces of glass", backdrop: "backdrop of glass",
  glass: "glass", channel: "channel", flow: "optical flow", layer: "layer of a channel", instances: "instances", toneMap: "tone mapping", edgeFilter: "edge smoothing",
  alpha: "alpha of the background", straightAlpha: "straight alpha",
  twirl: "twirl", convolve: "convolution", glowBright: "glow: threshold", glowDown: "glow: downsampling", glowUp: "glow: upsampling",
  glow: "glow: composition",
};
export const kindText = (kind) => kKinds[kind] ?? labelOf(kind).toLowerCase();

// subject: of a pass, decision or map; null for the view as a whole.
export const subjectText = (subject, otherwise) => labelOf(subject?.name || otherwise);

export const count = (n, one, many = `${one}s`) => `${n.toLocaleString("en")} ${n === 1 ? one : many}`;

export const sizeText = (bytes) => (bytes < 1 << 20 ? `${Math.round(bytes / 1024)} KB` : `${Math.round(bytes / 1048576)} MB`);

export function millisecondsText(ms) {
  if (ms >= 10000) return `${(ms / 1000).toFixed(1)} s`;
  return `${ms >= 100 ? ms.toFixed(0) : ms.toFixed(1)} ms`;
}

// ---- the message over the image --------------------------------------------------------------

let countdown;

// Screen readers announce a status whenever it is written, also if it is the same.
function write(part, text = "") {
  if (part.textContent !== text) part.textContent = text;
}

function show(title, text, className) {
  clearInterval(countdown);
  const note = $("note");
  note.hidden = !title && !text;
  note.className = className ?? "";
  write(note.querySelector("strong"), title);
  write($("note-text"), text);
  $("countdown").textContent = "";
  note.querySelector("p").hidden = !text;
  note.querySelector("progress").hidden = true;
}

export const clearMessage = () => show();
export const showMessage = (title, text, className) => show(title, text, className);

// Why something that the user did failed.
export function failureText(problem) {
  const { title, lines } = messageOf(problem);
  return [problem.status === 422 ? "" : `${title}.`, ...lines].filter(Boolean).join(" ");
}
export const showFailure = (title, problem) => show(title, failureText(problem), "bad");

// fraction: in [0, 1], or undefined if it is unknown.
export function showProgress(title, text, fraction) {
  show(title, text);
  const bar = $("note").querySelector("progress");
  bar.hidden = false;
  if (fraction === undefined) bar.removeAttribute("value");
  else bar.value = fraction;
}

// seconds: until the automatic retry, or undefined. The countdown is hidden from screen readers, which would announce every second.
export function showProblem(problem, seconds) {
  const { title, lines } = messageOf(problem);
  show(title, [...lines, seconds ? "Retrying" : ""].filter(Boolean).join("\n"), "bad");
  if (!seconds) return;
  let left = Math.ceil(seconds);
  const update = () => { $("countdown").textContent = ` in ${left} s.`; };
  update();
  countdown = setInterval(() => (--left > 0 ? update() : clearInterval(countdown)), 1000);
}
