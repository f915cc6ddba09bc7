// The panels "Cost" and "Maps": passes, decisions and maps of a frame.
import { Problem, renderFrame } from "./api.js";
import { $, element, showBlob, svg } from "./dom.js";
import { count, effectText, kindText, messageText, millisecondsText, subjectText, techniqueText } from "./messages.js";

// ---- plans as rows ---------------------------------------------------------------------------

// Equal for the passes of one object, map or filter; of the view itself, for those of one name.
const ownerOf = ({ name, subject }) => (subject ? `${subject.kind} ${subject.index ?? ""} ${subject.name}` : name);

// The passes of a plan, grouped by the object that they belong to, in the order of the frame.
// -> [{ title, effect, kinds: [{ text, count }], milliseconds, draws, triangles, size, reason }]; milliseconds is undefined
// if it was not measured.
export function planRows({ passes }) {
  const rows = new Map();
  for (const pass of passes) {
    const owner = ownerOf(pass);
    const row = rows.get(owner) ?? {
      title: pass.subject ? subjectText(pass.subject, pass.kind) : kindText(pass.kind),
      effect: effectText(pass.effect), kinds: new Map(), milliseconds: undefined, draws: 0, triangles: 0,
      size: pass.width ? `${pass.width} × ${pass.height}` : "", reason: pass.reason, generations: 0,
    };
    rows.set(owner, row);
    row.kinds.set(pass.kind, (row.kinds.get(pass.kind) ?? 0) + 1);
    if (pass.milliseconds !== undefined) row.milliseconds = (row.milliseconds ?? 0) + pass.milliseconds;
    row.draws += pass.draws;
    row.triangles += pass.triangles;
    row.generations = Math.max(row.generations, pass.generation);
  }
  return [...rows.values()].map((row) => ({
    ...row,
    title: row.title[0].toUpperCase() + row.title.slice(1),
    kinds: [...row.kinds].map(([kind, count]) => ({ text: kindText(kind), count })),
  }));
}

// Equal decisions are one row: the fifteen panes of a window, for example.
export function decisionRows({ decisions }) {
  const rows = new Map();
  for (const d of decisions ?? []) {
    const key = `${d.name} ${d.effect} ${d.taken}`;
    const row = rows.get(key);
    if (row) ++row.times;
    else {
      rows.set(key, {
        title: subjectText(d.subject, d.name), effect: effectText(d.effect), taken: techniqueText(d.taken), reason: d.reason, times: 1,
        candidates: d.candidates.map((c) => ({
          method: techniqueText(c.method), milliseconds: c.milliseconds, error: c.error, taken: c.method === d.taken,
        })),
      });
    }
  }
  return [...rows.values()];
}

export function skippedRows({ skipped }) {
  const rows = new Map();
  for (const s of skipped ?? []) {
    const key = `${s.name} ${s.reason}`;
    if (rows.has(key)) ++rows.get(key).times;
    else rows.set(key, { title: subjectText(s.subject, s.name), effect: effectText(s.effect), reason: s.reason, times: 1 });
  }
  return [...rows.values()];
}

// The largest parts of the time of a frame, and the rest.
export function timeParts(timings, maxParts = 5) {
  const total = timings.find((t) => t.name === "total")?.milliseconds ?? 0;
  const parts = timings.filter((t) => t.name !== "total" && t.milliseconds > 0)
    .sort((a, b) => b.milliseconds - a.milliseconds);
  const shown = parts.slice(0, maxParts);
  const rest = Math.max(0, total - shown.reduce((sum, p) => sum + p.milliseconds, 0));
  return { total, parts: rest > 0 ? [...shown, { name: "rest", milliseconds: rest }] : shown };
}

// ---- cost panel ------------------------------------------------------------------------------

// A bar as SVG, because the Content-Security-Policy forbids style attributes.
function bar(fraction, className = "") {
  const width = Math.max(0, Math.min(100, 100 * fraction));
  return svg("svg", { class: `bar ${className}`, viewBox: "0 0 100 4", preserveAspectRatio: "none", "aria-hidden": "true" },
             svg("rect", { width: 100, height: 4, class: "ground" }), svg("rect", { width, height: 4, class: "full" }));
}

const timeTexts = {
  queue: "queue", plan: "planning", readback: "readback", encode: "JPEG encoding", rest: "other",
};

function timesOf(timings) {
  const { total, parts } = timeParts(timings);
  let x = 0;
  const strip = svg("svg", { class: "strip", viewBox: "0 0 100 6", preserveAspectRatio: "none", "aria-hidden": "true" },
    ...parts.map(({ milliseconds }, i) => {
      const width = total > 0 ? (100 * milliseconds) / total : 0;
      const part = svg("rect", { x, width: Math.max(0, width - 0.3), height: 6, class: `share share-${i % 6}` });
      x += width;
      return part;
    }));
  const legend = element("ul", { className: "legend" }, ...parts.map(({ name, milliseconds }, i) =>
    element("li", { className: `share-${i % 6}` }, timeTexts[name] ?? kindText(name), element("b", {}, millisecondsText(milliseconds)))));
  return [strip, legend];
}

function passRow(row, maxMs) {
  const kinds = row.kinds.map(({ text, count: n }) => (n > 1 ? `${n} × ${text}` : text));
  const details = [kinds.join(", "), row.size, row.draws ? count(row.draws, "draw") : ""].filter(Boolean).join(" · ");
  return element("li", {},
    element("div", { className: "split" }, element("b", {}, row.title),
            element("span", { className: "number" }, row.milliseconds === undefined ? "" : millisecondsText(row.milliseconds))),
    bar((row.milliseconds ?? 0) / maxMs),
    element("small", {}, details), element("small", { className: "reason" }, row.reason));
}

function decisionRow(row) {
  const maxMs = Math.max(...row.candidates.map((c) => c.milliseconds), 1e-6);
  return element("li", {},
    element("details", {},
      element("summary", {}, element("b", {}, row.title), row.times > 1 ? ` × ${row.times}` : "",
              element("span", { className: "taken" }, row.taken)),
      element("table", {}, element("caption", { className: "visually-hidden", textContent: "Candidates" }),
        element("tbody", {}, ...row.candidates.map((c) => element("tr", { className: c.taken ? "taken" : "" },
          element("th", { scope: "row" }, c.method), element("td", {}, bar(c.milliseconds / maxMs)),
          element("td", {}, millisecondsText(c.milliseconds)), element("td", {}, `error ${c.error.toFixed(2)}`)))))),
    element("small", { className: "reason" }, row.reason));
}

const emptyRow = (text) => [element("li", { className: "quiet" }, text)];

export function showCost({ plan, timings, accuracy }, { width, height }) {
  const { total } = timeParts(timings);
  $("total").textContent = `${millisecondsText(total)} for ${width} × ${height} pixels`;
  $("chosen").textContent = accuracy;
  $("shares").replaceChildren(...timesOf(timings));
  const rows = planRows(plan);
  const maxMs = Math.max(...rows.map((r) => r.milliseconds ?? 0), 1e-6);
  $("rows").replaceChildren(...rows.map((row) => passRow(row, maxMs)));
  const decisions = decisionRows(plan);
  $("decisions").replaceChildren(...(decisions.length ? decisions.map(decisionRow) : emptyRow("None in this view.")));
  const skipped = skippedRows(plan);
  $("skipped").replaceChildren(...(skipped.length ? skipped.map((row) => element("li", {},
    element("b", {}, row.title), row.times > 1 ? ` × ${row.times}` : "", element("small", { className: "reason" }, row.reason)))
    : emptyRow("Nothing.")));
}

// ---- maps panel ------------------------------------------------------------------------------

// Shows the mirrored views and captured cubes that the frame reads.
export async function showMaps(request) {
  $("maps-words").textContent = "Rendering…";
  try {
    const { maps } = await renderFrame(request, "maps");
    $("maps-words").textContent = maps.length ? "" : "This view uses no mirrored views and no captured cubes.";
    $("maps").replaceChildren(...maps.map(({ subject, blob }) => {
      const title = subjectText(subject, "map");
      const image = element("img", { alt: `Map of ${title}` });
      showBlob(image, blob);
      const kind = subject?.kind === "mirror" ? "mirrored view" : "cube: +X −X +Y, −Y +Z −Z";
      return element("figure", {}, image, element("figcaption", {}, element("b", {}, title), ` ${kind}`));
    }));
  } catch (problem) {
    if (!(problem instanceof Problem)) throw problem;
    $("maps-words").textContent = messageText(problem);
  }
}
