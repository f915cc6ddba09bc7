// The panel "Compare": error against time of the present view, measured by a job, with error images.
import { Problem, cancelJob, imageAt, jobOf, startComparison } from "./api.js";
import { $, element, showBlob, svg } from "./dom.js";
import { messageText, millisecondsText } from "./messages.js";

// ---- settings, hull and axes -----------------------------------------------------------------

// The settings to compare: the presets, the current setting, and with `sweep` each field of the accuracy changed separately.
// schemas, values: of these fields. -> [{ label, accuracy }]; at most maxSettings.
export function settingsFor({ presets, current, schemas, values, sweep, maxSettings = 32 }) {
  const list = presets.map((preset) => ({ label: preset, accuracy: preset, named: true }));
  if (Object.keys(current).length > 1) list.push({ label: "current setting", accuracy: current, named: true });
  if (sweep) {
    for (const [name, schema] of Object.entries(schemas)) {
      for (const value of variants(schema, values[name])) {
        list.push({ label: `${name} ${value}`, accuracy: { ...current, [name]: value } });
      }
    }
  }
  return list.slice(0, maxSettings);
}

function variants(schema, value) {
  if (schema.enum) return schema.enum.filter((word) => word !== value && word !== "automatic");
  if (schema.type === "boolean") return [!value];
  if (value === undefined) return [];  // a budget
  const isInteger = schema.type === "integer";
  return [value / 2, value * 2].map((x) => (isInteger ? Math.round(x) : x))
    .filter((x) => x >= schema.minimum && x <= schema.maximum && x !== value);
}

// The lower left convex hull in logarithms of time and error.
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

// 1, 2 and 5 times powers of ten in the range; fewer if that is more than six.
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

// A logarithmic axis of `length` pixels that contains the values, with a margin at both ends.
export function logAxis(values, length) {
  const positive = values.filter((v) => v > 0);
  const low = Math.min(...positive) / 1.3, high = Math.max(...positive) * 1.3;
  const span = Math.log(high / low);
  return { low, high, at: (v) => (Math.log(Math.max(v, low) / low) / span) * length, ticks: logTicks(low, high) };
}

export const shortNumber = (v) => (v >= 1000 ? `${v / 1000}k` : String(Number(v.toPrecision(2))));

// ---- panel -----------------------------------------------------------------------------------

const kWidth = 320, kHeight = 220, kLeft = 46, kBottom = 34, kTop = 10, kRight = 12;
const kRadius = 5, kSelectedRadius = 7;  // of a point

// A point is a button: select(i) is called by a click, Enter or Space.
function chartOf(points, { off, noise }, select) {
  const x = logAxis(points.map((p) => p.milliseconds), kWidth - kLeft - kRight);
  const y = logAxis([...points.map((p) => p.error), off].filter((v) => v > 0), kHeight - kTop - kBottom);
  const px = (v) => kLeft + x.at(v), py = (v) => kHeight - kBottom - y.at(v);
  const line = (v, className, label) => (v >= y.low && v <= y.high
    ? [svg("line", { x1: kLeft, x2: kWidth - kRight, y1: py(v), y2: py(v), class: className }),
       svg("text", { x: kWidth - kRight, y: py(v) - 4, class: "end" }, label)] : []);
  const hull = hullOf(points);
  return svg("svg", { viewBox: `0 0 ${kWidth} ${kHeight}`, role: "group", "aria-label": "Error against milliseconds" },
    ...x.ticks.flatMap((t) => [
      svg("line", { x1: px(t), x2: px(t), y1: kTop, y2: kHeight - kBottom, class: "grid" }),
      svg("text", { x: px(t), y: kHeight - kBottom + 14, class: "middle" }, shortNumber(t))]),
    ...y.ticks.flatMap((t) => [
      svg("line", { x1: kLeft, x2: kWidth - kRight, y1: py(t), y2: py(t), class: "grid" }),
      svg("text", { x: kLeft - 6, y: py(t) + 4, class: "end" }, shortNumber(t))]),
    svg("text", { x: (kLeft + kWidth) / 2, y: kHeight - 4, class: "middle" }, "milliseconds per frame"),
    svg("text", { x: -(kHeight - kBottom) / 2, y: 11, class: "middle", transform: "rotate(-90)" }, "error, relMSE"),
    ...line(off, "off", "all effects off"), ...line(noise, "off", "noise of the reference"),
    svg("polyline", { class: "hull", points: hull.map((p) => `${px(p.milliseconds)},${py(p.error)}`).join(" ") }),
    ...points.filter((p) => p.named).map((p) =>
      svg("text", { x: px(p.milliseconds), y: py(p.error) - 9, class: "middle" }, p.label)),
    ...points.map((p, i) => {
      const label = `${p.label}: ${millisecondsText(p.milliseconds)}, error ${shortNumber(p.error)}`;
      const on = hull.some((h) => h.label === p.label);
      const press = (e) => {
        if (e.key !== "Enter" && e.key !== " ") return;
        e.preventDefault();  // Space would scroll
        select(i);
      };
      return svg("circle", { cx: px(p.milliseconds), cy: py(p.error), r: kRadius, tabindex: 0, role: "button", class: on ? "on" : "",
                             "aria-label": label, onclick: () => select(i), onkeydown: press }, svg("title", {}, label));
    }));
}

// What a measurement depends on: everything except size, accuracy and filters.
const viewOf = ({ width, height, accuracy, filters, ...view }) => JSON.stringify(view);

export class ComparePanel {
  #job;
  #points = [];
  #measured;  // the view of the error images
  #summary;   // of the measurement
  #errorCalls = 0;  // of #showError()

  // request(size) -> the view; size(width) -> the size with its aspect ratio. use(accuracy) applies a setting.
  // reference(path) is called with the reference image of the measured view, or undefined if the view has changed.
  constructor({ session, request, size, use, reference }) {
    Object.assign(this, { session, request, size, use, reference });
    $("measure").addEventListener("click", () => this.#measure());
    $("measure-cancel").addEventListener("click", () => this.#job && cancelJob(this.#job).catch(() => {}));
  }

  // Called with the shown view. Hides images of another view.
  viewChanged(request) {
    if (this.#measured === undefined || this.#measured === viewOf(request)) return;
    this.#measured = undefined;
    this.#showError(undefined);
    this.reference(undefined);
  }

  async #measure() {
    const { session } = this;
    const settings = settingsFor({
      presets: session.presets, current: session.accuracy, schemas: session.accuracySchemas, sweep: $("sweep").checked,
      values: { ...session.presetValues[session.preset], ...session.accuracySettings },
    });
    const { accuracy, filters, ...frame } = this.request(this.size(Number($("reference-width").value)));
    this.#busy(true);
    try {
      const body = { ...frame, settings: settings.map((s) => s.accuracy), samples: Number($("reference-samples").value),
                     frames: 5, errorPictures: true };
      let job = await startComparison(body);
      this.#job = job.id;
      while (job.state === "queued" || job.state === "running") {
        $("measure-progress").value = job.progress ?? 0;
        $("measure-words").textContent = job.state === "queued" ? "Waiting for another job…"
          : `${job.progress < 0.7 ? "Path tracing the reference" : "Measuring the settings"}, ${Math.round(100 * job.progress)} %`;
        await new Promise((resolve) => setTimeout(resolve, 300));
        job = await jobOf(this.#job);
      }
      if (job.state === "done") {
        this.#measured = viewOf(frame);
        this.#show(job.result, settings);
        this.viewChanged(this.request(this.size(1)));
      }
      else $("measure-words").textContent = job.state === "cancelled" ? "Cancelled." : `Failed: ${job.failure ?? ""}`;
    } catch (problem) {
      if (!(problem instanceof Problem)) throw problem;
      $("measure-words").textContent = messageText(problem);
    } finally {
      this.#busy(false);
    }
  }

  #busy(on) {
    $("measure").disabled = on;
    $("measure-cancel").hidden = $("measure-progress").hidden = !on;
    if (!on) this.#job = undefined;
  }

  #show(result, settings) {
    this.#points = result.settings.map((s, i) => ({
      label: settings[i].label, named: settings[i].named, accuracy: settings[i].accuracy,
      milliseconds: s.milliseconds.median, error: s.error.frame.relMse, psnr: s.error.frame.psnr, flip: s.error.frame.flip,
      closedGap: s.closedGap, image: s.errorPicture,
    }));
    this.#summary = `${this.#points.length} settings; reference with ${result.reference.samples} paths per pixel in ${millisecondsText(result.reference.milliseconds)}. Select a point to see its errors.`;
    $("measure-words").textContent = this.#summary;
    const lines = { off: result.effectsOff.relMse, noise: result.reference.noise.relMse };
    $("chart").hidden = false;
    $("chart").replaceChildren(chartOf(this.#points, lines, (i) => this.#select(i)));
    this.#deselect();
    this.reference(result.reference.picture);
  }

  #circles() {
    return [...$("chart").querySelectorAll("circle")];
  }

  // The circles stay in the document, so that the one with the focus keeps it.
  #mark(selected) {
    for (const [i, circle] of this.#circles().entries()) {
      circle.classList.toggle("chosen", i === selected);
      circle.setAttribute("r", i === selected ? kSelectedRadius : kRadius);
    }
    $("chart-details").hidden = selected === undefined;
  }

  #deselect() {
    this.#mark(undefined);
    this.#showError(undefined);
  }

  #select(i) {
    this.#mark(i);
    const p = this.#points[i], words = $("measure-words");
    if (!this.#job && words.textContent !== this.#summary) words.textContent = this.#summary;  // instead of an earlier failure
    const opacity = element("input", { type: "range", min: 0, max: 1, step: 0.05, id: "error-opacity", title: "How much of the error image covers the frame", oninput: () => {
      $("error-image").style.opacity = opacity.value;
    } });
    opacity.value = 0.75;
    const closed = p.closedGap === undefined || p.closedGap === null ? "" : `, closes ${Math.round(100 * p.closedGap)} % of the gap`;
    $("chart-details").replaceChildren(
      element("p", {}, element("b", {}, p.label), ` ${millisecondsText(p.milliseconds)}, relMSE ${shortNumber(p.error)}, PSNR ${p.psnr?.toFixed(1) ?? "?"} dB${closed}`),
      element("div", { className: "field" }, element("label", { htmlFor: "error-opacity" }, "Opacity of the error image"), opacity),
      element("div", { className: "row" },
        element("button", { type: "button", title: "Applies this accuracy to the view", onclick: () => this.use(p.accuracy) }, "Use this setting"),
        element("button", { type: "button", title: "Hides the error image", onclick: () => {
          this.#deselect();
          this.#circles()[i].focus();
        } }, "Hide")));
    this.#showError(p.image, opacity.value);
  }

  // Shows the error image at this path, or none. An image that arrives after a later call is ignored.
  async #showError(path, opacity) {
    const image = $("error-image"), call = ++this.#errorCalls;
    const isOutdated = () => call !== this.#errorCalls;
    image.hidden = true;
    if (!path) return;
    image.style.opacity = opacity;
    try {
      const blob = await imageAt(path);
      if (isOutdated()) return;
      await showBlob(image, blob);
      if (!isOutdated()) image.hidden = false;
    } catch (problem) {
      if (!(problem instanceof Problem)) throw problem;
      if (!isOutdated()) $("measure-words").textContent = messageText(problem);
    }
  }
}
