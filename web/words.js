// What the page says: problems, decisions and passes in plain words. Pure.
import { wordsOf } from "./schema.js";

const fieldWords = ({ pointer, detail, allowed }) =>
  `${pointer || "The request"} ${detail}${allowed ? ` (allowed: ${allowed})` : ""}`;

// -> { title, lines, waits }: waits says that asking again later may help without anybody's doing.
export function problemWords({ status, code, title, detail, errors = [] }) {
  switch (status) {
    case 0:
      return { title: "The server does not answer", lines: ["It may be restarting, or the network is gone."], waits: true };
    case 401:
    case 403:
      return { title: "The server does not let this page in", lines: [detail], waits: false };
    case 409:
      return { title, lines: [detail], waits: true };
    case 429:
      return { title: "Too many requests from here", lines: ["The server asks to slow down."], waits: true };
    case 502:
      return { title: "The server is not there", lines: ["Whatever stands before it got no answer; it may be restarting."], waits: true };
    case 503:
      return code === "shuttingDown"
        ? { title: "The server is shutting down", lines: ["The picture comes back when it does."], waits: true }
        : { title: "The server is busy", lines: [detail], waits: true };
    case 504:
      return { title: "This frame takes too long", lines: [detail, "A cheaper accuracy or fewer pixels fit."], waits: false };
    case 400:
    case 422:
      return { title: "The server refuses this request", lines: errors.length ? errors.map(fieldWords) : [detail], waits: false };
    default:
      return { title: `${title} (${status})`, lines: [detail], waits: false };
  }
}

const kMethods = {
  environment: "environment map", probe: "captured cube", mirror: "mirrored pass",
  backdrop: "picture behind it", traced: "traced rays",
};
export const methodWords = (method) => kMethods[method] ?? method;

const kEffects = {
  base: "The view", emission: "Emission", refraction: "Refraction", planarReflection: "Planar reflection",
  environmentReflection: "Environment reflection", filters: "Filters",
};
export const effectWords = (effect) => kEffects[effect] ?? wordsOf(effect ?? "other");

const kKinds = {
  environment: "environment map", prefilter: "roughness levels", levels: "smaller levels", capture: "cube faces",
  mirror: "mirrored view", surface: "surfaces", backFaces: "back faces of glass", backdrop: "copy behind glass",
  glass: "glass", channel: "numbers", toneMap: "tone mapping", edgeFilter: "smooth edges",
  twirl: "twirl", convolve: "convolution", glowBright: "glow: what is bright", glowDown: "glow: smaller", glowUp: "glow: spread",
  glow: "glow: put back",
};
export const kindWords = (kind) => kKinds[kind] ?? wordsOf(kind).toLowerCase();

// mirror:floor -> floor
export const subjectOf = (name) => {
  const rest = name.slice(name.indexOf(":") + 1);
  return wordsOf(rest.replace(/:(levels|capture|prefilter)$/, ""));
};

export const count = (n, one, many = `${one}s`) => `${n.toLocaleString("en")} ${n === 1 ? one : many}`;

export const sizeWords = (bytes) => (bytes < 1 << 20 ? `${Math.round(bytes / 1024)} KB` : `${Math.round(bytes / 1048576)} MB`);

export function millisecondsWords(ms) {
  if (ms >= 10000) return `${(ms / 1000).toFixed(1)} s`;
  return `${ms >= 100 ? ms.toFixed(0) : ms.toFixed(1)} ms`;
}
