// Saves the full frame of the view as a file.
import { Problem, renderFrame } from "./api.js";
import { $, element, fillSelect } from "./dom.js";
import { sceneIdOf } from "./joined.js";
import { showFailure } from "./messages.js";

const kFormats = { jpeg: ["JPEG", "jpg"], png: ["PNG", "png"], webp: ["WebP", "webp"] };

// `Brass lamp.glb`, 1280 x 720 -> "Brass lamp 1280x720.png". Characters that file systems refuse become "-".
export function fileName(title, { width, height }, format) {
  const name = title.replace(/\.[A-Za-z0-9]{1,5}$/, "").replace(/[\\/:*?"<>|\u0000-\u001f]+/g, "-").replace(/^[.\s-]+|[.\s]+$/g, "").slice(0, 100);
  return `${name || "frame"} ${width}x${height}.${kFormats[format][1]}`;
}

// fullRequest(): the request of the full frame; titleOf(id): of a scene. formats: of the server.
export function connectPicture({ fullRequest, titleOf, formats }) {
  fillSelect($("save-format"), Object.keys(kFormats).filter((f) => formats.includes(f)).map((f) => [f, kFormats[f][0]]), "png");
  $("save").addEventListener("click", async () => {
    const request = fullRequest(), format = $("save-format").value;
    if (!request) return;
    $("save").disabled = true;
    try {
      const { blob } = await renderFrame({ ...request, output: { ...request.output, format } });
      const url = URL.createObjectURL(blob);
      element("a", { href: url, download: fileName(titleOf(sceneIdOf(request.scene)), request, format) }).click();
      setTimeout(() => URL.revokeObjectURL(url), 60000);
    } catch (problem) {
      if (!(problem instanceof Problem)) throw problem;
      showFailure("The picture was not saved", problem);
    } finally {
      $("save").disabled = false;
      $("save").focus();
    }
  });
}
