// Accuracy against time: which settings to compare, the hull of what they reach, and where points and
// ticks lie. Pure; no drawing.

// Settings worth measuring beside the presets: the one at hand, and with `sweep` every knob moved by itself.
// -> [{ label, accuracy }]; at most `most`.
export function settingsFor({ presets, current, knobs, values, sweep, most = 32 }) {
  const list = presets.map((preset) => ({ label: preset, accuracy: preset }));
  if (Object.keys(current).length > 1) list.push({ label: "as set now", accuracy: current });
  if (sweep) {
    for (const [name, schema] of Object.entries(knobs)) {
      for (const value of variants(schema, values[name])) {
        list.push({ label: `${name} ${value}`, accuracy: { ...current, [name]: value } });
      }
    }
  }
  return list.slice(0, most);
}

function variants(schema, value) {
  if (schema.enum) return schema.enum.filter((word) => word !== value && word !== "automatic");
  if (schema.type === "boolean") return [!value];
  if (value === undefined) return [];  // a budget is no knob
  const whole = schema.type === "integer";
  return [value / 2, value * 2].map((x) => (whole ? Math.round(x) : x))
    .filter((x) => x >= schema.minimum && x <= schema.maximum && x !== value);
}

// The points that no mixture of others beats: the lower left hull, for logarithms of time and error.
export function hullOf(points) {
  const usable = points.filter((p) => p.milliseconds > 0 && p.error > 0)
    .map((p) => ({ ...p, x: Math.log(p.milliseconds), y: Math.log(p.error) }))
    .sort((a, b) => a.x - b.x || a.y - b.y);
  const hull = [];
  for (const p of usable) {
    if (hull.length && p.y >= hull.at(-1).y) continue;
    while (hull.length > 1 && turnsRight(hull.at(-2), hull.at(-1), p)) hull.pop();
    hull.push(p);
  }
  return hull;
}
const turnsRight = (a, b, c) => (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x) <= 0;

// 1, 2, 5 times powers of ten inside the range; fewer where there would be many.
export function logTicks(low, high) {
  const ticks = (steps) => {
    const list = [];
    for (let power = Math.floor(Math.log10(low)); power <= Math.ceil(Math.log10(high)); ++power) {
      for (const step of steps) {
        const value = Number((step * 10 ** power).toPrecision(1));
        if (value >= low && value <= high) list.push(value);
      }
    }
    return list;
  };
  for (const steps of [[1, 2, 5], [1, 3], [1]]) {
    const list = ticks(steps);
    if (list.length <= 6) return list;
  }
  return ticks([1]).filter((_, i) => i % 2 === 0);
}

// A logarithmic axis from the numbers on it to `length` pixels, with room at both ends.
export function logAxis(values, length) {
  const positive = values.filter((v) => v > 0);
  const low = Math.min(...positive) / 1.3, high = Math.max(...positive) * 1.3;
  const span = Math.log(high / low);
  return { low, high, at: (v) => (Math.log(Math.max(v, low) / low) / span) * length, ticks: logTicks(low, high) };
}

export const shortNumber = (v) => (v >= 1000 ? `${v / 1000}k` : String(Number(v.toPrecision(2))));
