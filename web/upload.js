// Opens files: dropped anywhere on the page, or selected. One after the other; each becomes a scene or an environment map.
import { Problem, uploadScene } from "./api.js";
import { $ } from "./dom.js";
import { bytesOf, contentOf, filesOf, kSupported, selectedFiles, uploadsOf } from "./files.js";
import { failureText, showFailure, showMessage, showProgress, sizeText } from "./messages.js";
import { showNotice } from "./notices.js";
import { loadedScene } from "./scene_choice.js";

export class Uploads {
  #queue = Promise.resolve();

  // choice: a SceneChoice. maps: a MapChoice. maxBytes: of a file, 0 if the server accepts none.
  constructor({ choice, maps, maxBytes }) {
    Object.assign(this, { choice, maps, maxBytes });
    this.#listenToDrops();
    if (!(maxBytes > 0)) return;
    $("upload-pick").hidden = false;
    $("upload-folder-button").hidden = $("upload-folder").hidden = !("webkitdirectory" in $("upload-folder"));
    for (const id of ["upload", "upload-folder"]) {
      $(id).addEventListener("change", async () => {
        const files = selectedFiles($(id).files);
        $(id).value = "";  // so that the same file can be selected again
        await this.#add(files);
      });
    }
  }

  #listenToDrops() {
    const hasFiles = (e) => e.dataTransfer?.types.includes("Files");
    let depth = 0;  // of the elements that the pointer has entered
    const highlight = () => { $("drop").hidden = depth <= 0; };
    $("drop").textContent = this.maxBytes > 0 ? "Drop scenes (files, folders or archives) or environment maps" : "This server does not accept files";
    addEventListener("dragenter", (e) => {
      if (!hasFiles(e)) return;
      ++depth;
      highlight();
    });
    addEventListener("dragleave", (e) => {
      if (!hasFiles(e)) return;
      --depth;
      highlight();
    });
    addEventListener("dragover", (e) => hasFiles(e) && e.preventDefault());
    addEventListener("drop", async (e) => {
      if (!hasFiles(e)) return;
      e.preventDefault();
      depth = 0;
      highlight();
      const entries = [...e.dataTransfer.items].map((item) => item.webkitGetAsEntry?.()).filter(Boolean);
      const plain = selectedFiles(e.dataTransfer.files);
      if (!(this.maxBytes > 0)) return showMessage("This server does not accept files", "It does with: clerestory serve --uploads DIR", "bad");
      try {
        await this.#add(entries.length ? await filesOf(entries) : plain);
      } catch (error) {
        if (!(error instanceof DOMException)) throw error;  // a file that vanished or cannot be read
        showMessage("The files could not be read", error.message, "bad");
      }
    });
  }

  // Opens files after those that were added before, also if those failed.
  #add(files) {
    const opened = this.#queue.then(() => this.#openAll(uploadsOf(files)));
    this.#queue = opened.catch(() => {});
    return opened;
  }

  async #openAll({ uploads, maps, others }) {
    const failures = [], all = [...uploads, ...maps];
    for (const [i, one] of all.entries()) {
      const of = all.length > 1 ? ` (${i + 1} of ${all.length})` : "";
      try {
        await (one.files ? this.#open(one, of) : this.#openMap(one, of));
      } catch (problem) {
        if (!(problem instanceof Problem)) throw problem;
        if (all.length === 1) showFailure(`${one.name} could not be opened`, problem);
        else failures.push(`${one.name}: ${failureText(problem)}`);
      }
    }
    if (failures.length) {
      showNotice("uploads", `${failures.length} of ${all.length} could not be opened`, failures, { open: true, about: {} });
      if (failures.length === all.length) showMessage("No file could be opened", "The reasons are below the image.", "bad");
    }
    if (!all.length && others.length) showMessage(`${others.slice(0, 3).join(", ")}${others.length > 3 ? "…" : ""}: no scene`, kSupported, "bad");
  }

  #requireSize(size) {
    if (size <= this.maxBytes) return;
    throw new Problem({ status: 413, title: "Too large", detail: `It has ${sizeText(size)}; the limit of the server is ${sizeText(this.maxBytes)}.` });
  }

  // Uploads a map and shows the scene in its light.
  async #openMap(map, of) {
    this.#requireSize(map.file.size);
    await this.maps.open(map, (fraction) => showProgress(`Uploading ${map.name}${of}`, "", fraction));
  }

  // Uploads a scene and shows it; if that fails, the present scene stays.
  async #open(upload, of) {
    const { name } = upload, { choice } = this;
    this.#requireSize(bytesOf(upload));
    const before = $("scene").value;
    const id = await uploadScene(contentOf(upload), name, (fraction) => showProgress(`Uploading ${name}${of}`, "", fraction));
    const isUnchanged = () => $("scene").value === before;
    const scene = await loadedScene(id, `${name}${of}`, isUnchanged);  // selected afterwards: a scene that fails is not in the list
    if (!scene && isUnchanged()) return;
    const isShown = isUnchanged();
    await choice.list(isShown ? id : $("scene").value);
    if (isShown) await choice.choose(id);
  }
}
