// The choice of the scene: the list, loading with its progress, and the switch from one scene to another.
import { Problem, getJson, renderFrame } from "./api.js";
import { $, element, fillSelect } from "./dom.js";
import { retryDelay } from "./frames.js";
import { sceneIdOf } from "./joined.js";
import { clearMessage, messageOf, showFailure, showMessage, showProblem, showProgress } from "./messages.js";
import { showNotice, warningLines } from "./notices.js";

const wait = (seconds) => new Promise((resolve) => setTimeout(resolve, 1000 * seconds));
const sceneAt = (id) => getJson(`v1/scenes/${encodeURIComponent(id)}`);

// Waits until the scene is loaded, and shows the progress. A waiting scene is loaded when a frame of it is requested.
// Returns undefined if stillWanted() is false. Throws a Problem if it cannot be loaded.
export async function loadedScene(id, title, stillWanted) {
  for (let failures = 0; stillWanted();) {
    try {
      const scene = await sceneAt(id);
      failures = 0;
      if (scene.state === "ready") return scene;
      if (scene.state === "failed") throw new Problem({ status: 422, title: "", detail: scene.failure ?? "no reason is known" });
      if (!stillWanted()) return undefined;
      showProgress(`Loading ${title}`, scene.stage ?? "", scene.progress);
      if (scene.state === "waiting") await renderFrame({ scene: id, width: 1, height: 1 });
    } catch (problem) {
      if (!(problem instanceof Problem)) throw problem;
      if (problem.status !== 409) {
        if (!messageOf(problem).retry) throw problem;
        const seconds = retryDelay(problem.retryAfterSeconds, ++failures);
        showProblem(problem, seconds);
        await wait(seconds);
      }
    }
    await wait(0.3);
  }
  return undefined;
}

export class SceneChoice {
  shownId;  // of the scene of the shown frame
  #opening; // id of the scene that is being loaded
  #titles = new Map();

  // frames: is stopped and begun. opened(view): called when the session has the new scene, before its first frame.
  // acceptsFiles: the server accepts uploads.
  constructor({ session, frames, opened, acceptsFiles }) {
    Object.assign(this, { session, frames, opened, acceptsFiles });
    $("scene").addEventListener("change", () => this.choose($("scene").value));
  }

  get opening() {
    return this.#opening !== undefined;
  }
  // [[id, title]] of the scenes of the list.
  get titles() {
    return [...this.#titles];
  }
  titleOf(id) {
    return this.#titles.get(id) ?? id;
  }

  // Reads the list of scenes again. -> the selected id; undefined if there is no scene `wanted`, which is then reported.
  async list(wanted) {
    const { scenes } = await getJson("v1/scenes");
    this.#titles = new Map(scenes.map((s) => [s.id, s.title || s.id]));
    const first = scenes.find((s) => s.default) ?? scenes[0];
    const isMissing = wanted !== undefined && !this.#titles.has(wanted) && await this.#isUnknown(wanted);
    if (wanted !== undefined && !isMissing && !this.#titles.has(wanted)) this.#titles.set(wanted, wanted);
    fillSelect($("scene"), [...this.#titles], isMissing ? "" : wanted ?? first.id);
    if (!isMissing) return $("scene").value;
    $("scene").prepend(element("option", { value: "", disabled: true, selected: true, textContent: "choose a scene…" }));
    showMessage(`There is no scene “${wanted}”`,
      "This link names a scene that the server does not have: it may have been deleted, or uploaded to another server.\n" +
      `Choose a scene of the list${this.acceptsFiles ? ", or drop the file of that scene here" : ""}.`, "bad");
    return undefined;
  }
  // Scenes that are not in the list may exist: the other scenes of a file that is not loaded.
  async #isUnknown(id) {
    try {
      await sceneAt(id);
    } catch (problem) {
      if (!(problem instanceof Problem)) throw problem;
      return problem.status === 404;
    }
    return false;
  }

  // Loads and shows a scene. Its predecessor disappears at once; if loading fails, it is shown again. view: instead of the default one.
  async choose(id, view) {
    this.#opening = id;
    this.frames.stop();
    showNotice("warnings", "", []);
    this.#show();
    let scene;
    try {
      scene = await loadedScene(id, this.titleOf(id), () => this.#opening === id);
    } catch (problem) {
      if (!(problem instanceof Problem)) throw problem;
      if (this.#opening !== id) return;
      showFailure(`${this.titleOf(id)} could not be loaded`, problem);
    }
    if (this.#opening !== id) return;
    this.#opening = undefined;
    if (!scene) {
      if (this.shownId !== undefined) $("scene").value = this.shownId;
      return this.#show(false);
    }
    clearMessage();
    this.session.scene = scene;
    this.opened(view);
    const warnings = warningLines(scene.warnings);
    showNotice("warnings", `${warnings.length === 1 ? "1 warning" : `${warnings.length} warnings`} about ${this.titleOf(id)}`, warnings, { about: id });
    this.frames.begin();
    this.#showCompilation(id);
  }

  // Called with every frame.
  shown({ scene }, still) {
    this.shownId = sceneIdOf(scene);
    this.#show(!still && $("stage").classList.contains("busy"));
  }
  failed() {
    $("stage").classList.remove("busy");
    $("stage").setAttribute("aria-busy", false);
  }

  // The old image is hidden while another scene is opened; busy: the first full frame of the scene is not complete.
  #show(busy = true) {
    const { classList } = $("stage");
    classList.toggle("busy", busy);
    classList.toggle("opening", this.opening || (busy && this.shownId !== this.session.scene?.id));
    $("stage").setAttribute("aria-busy", busy);
  }

  // Shows how many shaders are compiled until the first frame of the scene is shown.
  async #showCompilation(id) {
    const isAwaited = () => this.shownId !== id && !this.opening && this.session.scene.id === id;
    for (await wait(1); isAwaited(); await wait(0.5)) {
      try {
        const { shaders } = await sceneAt(id);
        if (!shaders || shaders.finished) return;
        if (!isAwaited() || shaders.total === 0) continue;
        showProgress(`Compiling shaders for ${this.titleOf(id)}`, `${shaders.compiled} of ${shaders.total} programs`,
          shaders.compiled / shaders.total);
      } catch (problem) {
        if (!(problem instanceof Problem)) throw problem;
        return;
      }
    }
  }
}
