// Accuracy against time of this view: a comparison as a job, its chart, its error pictures.
import { Problem, cancelJob, jobOf, pictureAt, startComparison } from "./api.js";
import { hullOf, logAxis, settingsFor, shortNumber } from "./chart.js";
import { $, element, showBlob, svg } from "./dom.js";
import { millisecondsWords, problemWords } from "./words.js";

const kWidth = 320, kHeight = 220, kLeft = 46, kBottom = 34, kTop = 10, kRight = 12;

function chartOf(points, { off, noise }, chosen, choose) {
  const x = logAxis(points.map((p) => p.milliseconds), kWidth - kLeft - kRight);
  const y = logAxis([...points.map((p) => p.error), off].filter((v) => v > 0), kHeight - kTop - kBottom);
  const px = (v) => kLeft + x.at(v), py = (v) => kHeight - kBottom - y.at(v);
  const line = (v, className, words) => (v >= y.low && v <= y.high
    ? [svg("line", { x1: kLeft, x2: kWidth - kRight, y1: py(v), y2: py(v), class: className }),
       svg("text", { x: kWidth - kRight, y: py(v) - 4, class: "end" }, words)] : []);
  const hull = hullOf(points);
  return svg("svg", { viewBox: `0 0 ${kWidth} ${kHeight}`, role: "group", "aria-label": "Error against milliseconds" },
    ...x.ticks.flatMap((t) => [
      svg("line", { x1: px(t), x2: px(t), y1: kTop, y2: kHeight - kBottom, class: "grid" }),
      svg("text", { x: px(t), y: kHeight - kBottom + 14, class: "middle" }, shortNumber(t))]),
    ...y.ticks.flatMap((t) => [
      svg("line", { x1: kLeft, x2: kWidth - kRight, y1: py(t), y2: py(t), class: "grid" }),
      svg("text", { x: kLeft - 6, y: py(t) + 4, class: "end" }, shortNumber(t))]),
    svg("text", { x: (kLeft + kWidth) / 2, y: kHeight - 4, class: "middle" }, "milliseconds a frame"),
    svg("text", { x: -(kHeight - kBottom) / 2, y: 11, class: "middle", transform: "rotate(-90)" }, "error, relMSE"),
    ...line(off, "off", "all effects off"), ...line(noise, "off", "noise of the truth"),
    svg("polyline", { class: "hull", points: hull.map((p) => `${px(p.milliseconds)},${py(p.error)}`).join(" ") }),
    ...points.filter((p) => p.named).map((p) =>
      svg("text", { x: px(p.milliseconds), y: py(p.error) - 9, class: "middle" }, p.label)),
    ...points.map((p, i) => {
      const words = `${p.label}: ${millisecondsWords(p.milliseconds)}, error ${shortNumber(p.error)}`;
      const on = hull.some((h) => h.label === p.label);
      return svg("circle", { cx: px(p.milliseconds), cy: py(p.error), r: i === chosen ? 7 : 5, tabindex: 0, role: "button",
                             class: [on ? "on" : "", i === chosen ? "chosen" : ""].join(" "), "aria-label": words,
                             onclick: () => choose(i), onkeydown: (e) => e.key === "Enter" && choose(i) },
                 svg("title", {}, words));
    }));
}

// What a measurement depends on: everything but size, accuracy and filters.
const viewOf = ({ width, height, accuracy, filters, ...view }) => JSON.stringify(view);

export class ComparePanel {
  #job;
  #points = [];
  #lines = {};
  #measured;  // the view that the pictures belong to

  // request(size) -> the view; size(width) -> a picture of its shape. use(accuracy): take it over.
  // truth(path): a picture of the measured view's truth is there, or, with nothing, no longer fits.
  constructor({ session, request, size, use, truth }) {
    Object.assign(this, { session, request, size, use, truth });
    $("measure").addEventListener("click", () => this.#measure());
    $("measure-cancel").addEventListener("click", () => this.#job && cancelJob(this.#job).catch(() => {}));
  }

  // This view is shown now: pictures of another one go.
  viewIs(request) {
    if (this.#measured === undefined || this.#measured === viewOf(request)) return;
    this.#measured = undefined;
    this.#showError(undefined);
    this.truth(undefined);
  }

  async #measure() {
    const { session } = this;
    const settings = settingsFor({
      presets: session.presets, current: session.accuracy, knobs: session.knobSchemas, sweep: $("sweep").checked,
      values: { ...session.presetValues[session.preset], ...session.knobs },
    });
    const { accuracy, filters, ...frame } = this.request(this.size(Number($("truth-edge").value)));
    this.#busy(true);
    try {
      const body = { ...frame, settings: settings.map((s) => s.accuracy), samples: Number($("truth-samples").value),
                     frames: 5, errorPictures: true };
      let job = await startComparison(body);
      this.#job = job.id;
      while (job.state === "queued" || job.state === "running") {
        $("measure-progress").value = job.progress ?? 0;
        $("measure-words").textContent = job.state === "queued" ? "Waiting for another measurement…"
          : `${job.progress < 0.7 ? "Tracing the truth" : "Measuring the settings"}, ${Math.round(100 * job.progress)} %`;
        await new Promise((resolve) => setTimeout(resolve, 300));
        job = await jobOf(this.#job);
      }
      if (job.state === "done") {
        this.#measured = viewOf(frame);
        this.#show(job.result, settings);
        this.viewIs(this.request(this.size(1)));
      }
      else $("measure-words").textContent = job.state === "cancelled" ? "Cancelled." : `It failed: ${job.failure ?? ""}`;
    } catch (problem) {
      if (!(problem instanceof Problem)) throw problem;
      const { title, lines } = problemWords(problem);
      $("measure-words").textContent = [title, ...lines].join(". ");
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
      label: settings[i]?.label ?? s.name, named: settings[i] && typeof settings[i].accuracy === "string" || settings[i]?.label === "as set now", accuracy: settings[i]?.accuracy ?? s.accuracy,
      milliseconds: s.milliseconds.median, error: s.error.frame.relMse, psnr: s.error.frame.psnr, flip: s.error.frame.flip,
      closedGap: s.closedGap, picture: s.errorPicture,
    }));
    this.#lines = { off: result.effectsOff.relMse, noise: result.reference.noise.relMse };
    $("measure-words").textContent = `${this.#points.length} settings, truth of ${result.reference.samples} paths a pixel in ${millisecondsWords(result.reference.milliseconds)}. Choose a point to see where it is wrong.`;
    this.#draw(undefined);
    this.truth(result.reference.picture);
  }

  #draw(chosen) {
    $("chart").hidden = false;
    $("chart").replaceChildren(chartOf(this.#points, this.#lines, chosen, (i) => this.#choose(i)));
    $("chart-details").hidden = chosen === undefined;
  }

  #choose(i) {
    this.#draw(i);
    const p = this.#points[i];
    const opacity = element("input", { type: "range", min: 0, max: 1, step: 0.05, id: "error-opacity", oninput: () => {
      $("error-picture").style.opacity = opacity.value;
    } });
    opacity.value = 0.75;
    const closed = p.closedGap === undefined || p.closedGap === null ? "" : `, closes ${Math.round(100 * p.closedGap)} % of the gap`;
    $("chart-details").replaceChildren(
      element("p", {}, element("b", {}, p.label), ` ${millisecondsWords(p.milliseconds)}, relMSE ${shortNumber(p.error)}, PSNR ${p.psnr?.toFixed(1) ?? "?"} dB${closed}`),
      element("div", { className: "field" }, element("label", { htmlFor: "error-opacity" }, "Error picture over the view"), opacity),
      element("div", { className: "row" },
        element("button", { type: "button", onclick: () => this.use(p.accuracy) }, "Use this setting"),
        element("button", { type: "button", onclick: () => { this.#showError(undefined); this.#draw(undefined); } }, "Hide")));
    this.#showError(p.picture, opacity.value);
  }

  async #showError(path, opacity) {
    const image = $("error-picture");
    image.hidden = true;
    if (!path) return;
    image.style.opacity = opacity;
    await showBlob(image, await pictureAt(path));
    image.hidden = false;
  }
}
