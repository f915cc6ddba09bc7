// The words over the picture: what the server says, what is loading, when it is asked again.
import { problemWords } from "./words.js";
import { $ } from "./dom.js";

let ticking;

function put(title, text, tone) {
  clearInterval(ticking);
  const note = $("note");
  note.hidden = !title && !text;
  note.className = tone ?? "";
  note.querySelector("strong").textContent = title ?? "";
  note.querySelector("span").textContent = text ?? "";
  note.querySelector("progress").hidden = true;
}

export const clear = () => put();
export const say = (title, text) => put(title, text);

// share: 0..1, or nothing while it is not known.
export function sayProgress(title, text, share) {
  put(title, text);
  const bar = $("note").querySelector("progress");
  bar.hidden = false;
  if (share === undefined) bar.removeAttribute("value");
  else bar.value = share;
}

// seconds: until the page asks again by itself; counted down before people's eyes.
export function sayProblem(problem, seconds) {
  const { title, lines } = problemWords(problem);
  const text = lines.filter(Boolean).join("\n");
  put(title, text, "bad");
  if (!seconds) return;
  let left = Math.ceil(seconds);
  const tell = () => { $("note").querySelector("span").textContent = `${text}\nTrying again in ${left} s.`; };
  tell();
  ticking = setInterval(() => (--left > 0 ? tell() : clearInterval(ticking)), 1000);
}
