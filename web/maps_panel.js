// The pictures behind a frame: mirrored views and captured cubes.
import { $, element, showBlob } from "./dom.js";
import { Problem, renderFrame } from "./api.js";
import { problemWords, subjectOf } from "./words.js";

export async function showMaps(request) {
  $("maps-words").textContent = "Drawing…";
  try {
    const { maps } = await renderFrame(request, "maps");
    $("maps-words").textContent = maps.length ? "" : "This view needs none: nothing in it is served by a mirrored view or a cube.";
    $("maps").replaceChildren(...maps.map(({ name, blob }) => {
      const image = element("img", { alt: `What ${subjectOf(name)} looks at` });
      showBlob(image, blob);
      const kind = name.startsWith("mirror:") ? "mirrored view" : "cube: +X −X +Y, −Y +Z −Z";
      return element("figure", {}, image, element("figcaption", {}, element("b", {}, subjectOf(name)), ` ${kind}`));
    }));
  } catch (problem) {
    if (!(problem instanceof Problem)) throw problem;
    const { title, lines } = problemWords(problem);
    $("maps-words").textContent = [title, ...lines].join(". ");
  }
}
