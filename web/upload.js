// Opens files: dropped anywhere on the page, or selected. One after the other; each becomes a scene.
import { Problem, uploadScene } from "./api.js";
import { $ } from "./dom.js";
import { bytesOf, contentOf, filesOf, kSupported, mapsText, selectedFiles, uploadsOf } from "./files.js";
import { failureText, showFailure, showMessage, showProgress, sizeText } from "./messages.js";
import { showNotice } from "./notices.js";
import { loadedScene } from "./scene_choice.js";

export class Uploads {
  #queue = Promise.resolve();

  // choice: a SceneChoice. maxBytes: of a file, 0 if the server accepts none. maps: names of loaded environment maps.
  constructor({ choice, maxBytes, maps }) {
    Object.assign(this, { choice, maxBytes, maps });
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
    $("drop").textContent = this.maxBytes > 0 ? "Drop scenes: files, folders or archives" : "This server does not accept files";
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

  #add(files) {
    return (this.#queue = this.#queue.then(() => this.#openAll(uploadsOf(files))));
  }

  async #openAll({ uploads, maps, others }) {
    const failures = [];
    for (const [i, upload] of uploads.entries()) {
      const of = uploads.length > 1 ? ` (${i + 1} of ${uploads.length})` : "";
      try {
        await this.#open(upload, of);
      } catch (problem) {
        if (!(problem instanceof Problem)) throw problem;
        if (uploads.length === 1) showFailure(`${upload.name} could not be opened`, problem);
        else failures.push(`${upload.name}: ${failureText(problem)}`);
      }
    }
    if (maps.length) showNotice("maps", `${maps.join(", ")} cannot be uploaded`, mapsText(maps, this.maps), { open: true, about: {} });
    if (failures.length) {
      showNotice("uploads", `${failures.length} of ${uploads.length} could not be opened`, failures, { open: true, about: {} });
      if (failures.length === uploads.length) showMessage("No file could be opened", "The reasons are below the image.", "bad");
    }
    if (!uploads.length && others.length) showMessage(`${others.slice(0, 3).join(", ")}${others.length > 3 ? "…" : ""}: no scene`, kSupported, "bad");
  }

  // Uploads a scene and shows it; if that fails, the present scene stays.
  async #open(upload, of) {
    const { name } = upload, size = bytesOf(upload), { choice } = this;
    if (size > this.maxBytes) {
      throw new Problem({ status: 413, title: "Too large", detail: `It has ${sizeText(size)}; the limit of the server is ${sizeText(this.maxBytes)}.` });
    }
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
