// A row for something that a request can change, closed at first.
import { element } from "./dom.js";

// controls(changed): its controls with their present values, which call changed() after a change. While isSet(), the row
// is marked and has a button that calls reset() and draws the controls again. tip, resetTip: of the row and of that button.
export function changeRow({ name, quiet, tip, resetTip, resetLabel = "Reset", controls, isSet, reset, changed }) {
  const summary = element("summary", { title: tip }, element("b", {}, name), element("span", { className: "quiet" }, quiet));
  const button = element("button", { type: "button", className: "plain", title: resetTip, onclick: () => {
    reset();
    draw();
    summary.focus();
    changed();
  } }, resetLabel);
  const row = element("details", { className: "light" });
  const mark = () => {
    row.classList.toggle("set", isSet());
    button.hidden = !isSet();
  };
  const draw = () => {
    row.replaceChildren(summary, ...controls(() => {
      mark();
      changed();
    }), element("div", { className: "row end" }, button));
    mark();
  };
  draw();
  return row;
}
