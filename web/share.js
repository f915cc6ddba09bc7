// Taking the view along: links, a curl command, JSON; and letting others watch it live.
import { $ } from "./dom.js";
import { curlOf, queryOf } from "./links.js";

async function copy(text, what) {
  try {
    await navigator.clipboard.writeText(text);
    $("copied").textContent = `Copied ${what}.`;
  } catch {
    $("copied").textContent = text;
  }
}

// session: what is shown; full(): the request of its full frame; changed(): show it again. paths: of the
// server's schema. -> { live() }: the name of the view that others watch, while they may.
export function share({ session, full, changed, paths }) {
  const base = new URL(".", location.href).href;
  $("copy-link").addEventListener("click", () => copy(`${base}#${session.query()}`, "a link to this page and view"));
  $("copy-picture").addEventListener("click", () => copy(`${base}v1/frames?${queryOf(full())}`,
    session.filters.length ? "a link to the picture, without its filters" : "a link to the picture"));
  $("copy-curl").addEventListener("click", () => copy(curlOf(full(), base), "the command"));
  $("copy-json").addEventListener("click", () => copy(JSON.stringify(full(), null, 2), "the request"));

  let live;
  $("live-row").hidden = !paths["/v1/stream"];
  $("live").addEventListener("change", () => {
    live = $("live").checked ? `page-${Math.random().toString(36).slice(2, 8)}` : undefined;
    $("live-words").hidden = !live;
    if (!live) return;
    $("live-link").href = $("live-link").textContent = new URL(`v1/stream?view=${live}`, base).href;
    changed();
  });
  return { live: () => live };
}
