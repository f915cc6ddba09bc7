// The plan of a frame as a list that people can read: passes of one thing together, with their share
// of the time, and what was left out. Pure.
import { effectWords, kindWords, methodWords, subjectOf } from "./words.js";

const ownerOf = ({ name }) => name.replace(/:(levels|capture|prefilter)$/, "");

// -> [{ title, effect, kinds: [{ words, count }], milliseconds, draws, triangles, size, reason }], in the
// order in which the frame does them. milliseconds is undefined where nothing was measured.
export function planRows({ passes }) {
  const rows = new Map();
  for (const pass of passes) {
    const owner = ownerOf(pass);
    const row = rows.get(owner) ?? {
      title: owner.includes(":") ? subjectOf(owner) : kindWords(pass.kind),
      effect: effectWords(pass.effect), kinds: new Map(), milliseconds: undefined, draws: 0, triangles: 0,
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
    kinds: [...row.kinds].map(([kind, count]) => ({ words: kindWords(kind), count })),
  }));
}

// Decisions with the same answer for the same thing stand once: fifteen panes of one window are a row.
export function decisionRows({ decisions }) {
  const rows = new Map();
  for (const d of decisions ?? []) {
    const key = `${d.name} ${d.effect} ${d.taken}`;
    const row = rows.get(key);
    if (row) ++row.times;
    else {
      rows.set(key, {
        title: subjectOf(d.name), effect: effectWords(d.effect), taken: methodWords(d.taken), reason: d.reason, times: 1,
        candidates: d.candidates.map((c) => ({
          method: methodWords(c.method), milliseconds: c.milliseconds, error: c.error, taken: c.method === d.taken,
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
    else rows.set(key, { title: subjectOf(s.name), effect: effectWords(s.effect), reason: s.reason, times: 1 });
  }
  return [...rows.values()];
}

// Where a frame's time goes: parts of one bar, the largest first, the rest together.
export function timeShares(timings, most = 5) {
  const total = timings.find((t) => t.name === "total")?.milliseconds ?? 0;
  const parts = timings.filter((t) => t.name !== "total" && t.milliseconds > 0)
    .sort((a, b) => b.milliseconds - a.milliseconds);
  const known = parts.slice(0, most);
  const rest = Math.max(0, total - known.reduce((sum, p) => sum + p.milliseconds, 0));
  return { total, parts: rest > 0 ? [...known, { name: "rest", milliseconds: rest }] : known };
}
