// Texts that stay below the image until they are dismissed: warnings of an import, and files that could not be opened.
import { $, element } from "./dom.js";

const kMaxLines = 100;

// Replaces the notice of that kind; without lines it is removed. A notice that was dismissed does not return for the same `about`.
const dismissed = new Set();
export function showNotice(kind, title, lines, { about = title, open = false } = {}) {
  $("notices").querySelector(`[data-kind=${kind}]`)?.remove();
  if (!lines?.length || dismissed.has(about)) return;
  const remove = element("button", { type: "button", className: "plain", title: "Hides this notice", onclick: () => {
    dismissed.add(about);
    notice.remove();
    $("stage").focus();
  } }, "×");
  remove.setAttribute("aria-label", `Dismiss: ${title}`);
  const shown = lines.length > kMaxLines ? [...lines.slice(0, kMaxLines), `and ${lines.length - kMaxLines} more`] : lines;
  const notice = element("div", { className: "notice" },
    element("details", { open }, element("summary", {}, element("b", {}, title)),
            element("ul", {}, ...shown.map((line) => element("li", {}, line)))), remove);
  notice.dataset.kind = kind;
  $("notices").append(notice);
}

// The lines of a scene's `warnings`.
export const warningLines = (warnings = []) => warnings.map(({ subject, message, count }) =>
  `${subject && !message.includes(subject) ? `${subject}: ` : ""}${message}${count > 1 ? ` (${count} times)` : ""}`);
