// What a frame cost and why: its plan with milliseconds as bars, decisions, what was left out.
import { $, element, svg } from "./dom.js";
import { decisionRows, planRows, skippedRows, timeShares } from "./plan.js";
import { count, kindWords, millisecondsWords } from "./words.js";

// A bar as SVG: its length is an attribute, not a style.
function bar(share, className = "") {
  const width = Math.max(0, Math.min(100, 100 * share));
  return svg("svg", { class: `bar ${className}`, viewBox: "0 0 100 4", preserveAspectRatio: "none", "aria-hidden": "true" },
             svg("rect", { width: 100, height: 4, class: "ground" }), svg("rect", { width, height: 4, class: "full" }));
}

const timeWords = {
  queue: "waiting", plan: "planning", readback: "reading back", encode: "making the JPEG", rest: "the rest",
};

function sharesOf(timings) {
  const { total, parts } = timeShares(timings);
  let x = 0;
  const strip = svg("svg", { class: "strip", viewBox: "0 0 100 6", preserveAspectRatio: "none", "aria-hidden": "true" },
    ...parts.map(({ milliseconds }, i) => {
      const width = total > 0 ? (100 * milliseconds) / total : 0;
      const part = svg("rect", { x, width: Math.max(0, width - 0.3), height: 6, class: `share share-${i % 6}` });
      x += width;
      return part;
    }));
  const legend = element("ul", { className: "legend" }, ...parts.map(({ name, milliseconds }, i) =>
    element("li", { className: `share-${i % 6}` }, timeWords[name] ?? kindWords(name), element("b", {}, millisecondsWords(milliseconds)))));
  return [strip, legend];
}

function passRow(row, most) {
  const kinds = row.kinds.map(({ words, count: n }) => (n > 1 ? `${n} × ${words}` : words));
  const small = [kinds.join(", "), row.size, row.draws ? count(row.draws, "draw") : ""].filter(Boolean).join(" · ");
  return element("li", {},
    element("div", { className: "split" }, element("b", {}, row.title),
            element("span", { className: "number" }, row.milliseconds === undefined ? "" : millisecondsWords(row.milliseconds))),
    bar((row.milliseconds ?? 0) / most),
    element("small", {}, small), element("small", { className: "reason" }, row.reason));
}

function decisionRow(row) {
  const most = Math.max(...row.candidates.map((c) => c.milliseconds), 1e-6);
  return element("li", {},
    element("details", {},
      element("summary", {}, element("b", {}, row.title), row.times > 1 ? ` × ${row.times}` : "",
              element("span", { className: "taken" }, row.taken)),
      element("table", {}, element("caption", { className: "unseen", textContent: "The ways to serve it" }),
        element("tbody", {}, ...row.candidates.map((c) => element("tr", { className: c.taken ? "taken" : "" },
          element("th", { scope: "row" }, c.method), element("td", {}, bar(c.milliseconds / most)),
          element("td", {}, millisecondsWords(c.milliseconds)), element("td", {}, `error ${c.error.toFixed(2)}`)))))),
    element("small", { className: "reason" }, row.reason));
}

const nothing = (words) => [element("li", { className: "quiet" }, words)];

export function showCost({ plan, timings, accuracy }, { width, height }) {
  const { total } = timeShares(timings);
  $("total").textContent = `${millisecondsWords(total)} for ${width} × ${height} pixels`;
  $("chosen").textContent = accuracy;
  $("shares").replaceChildren(...sharesOf(timings));
  const rows = planRows(plan);
  const most = Math.max(...rows.map((r) => r.milliseconds ?? 0), 1e-6);
  $("rows").replaceChildren(...rows.map((row) => passRow(row, most)));
  const decisions = decisionRows(plan);
  $("decisions").replaceChildren(...(decisions.length ? decisions.map(decisionRow) : nothing("This view has none.")));
  const skipped = skippedRows(plan);
  $("skipped").replaceChildren(...(skipped.length ? skipped.map((row) => element("li", {},
    element("b", {}, row.title), row.times > 1 ? ` × ${row.times}` : "", element("small", { className: "reason" }, row.reason)))
    : nothing("Nothing.")));
}
