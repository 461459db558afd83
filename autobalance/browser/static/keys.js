// Keys for steps, views and the main button; single letters and digits do nothing while a field has the focus.
import { $ } from "/static/tools.js";
import { emit, redoJob, state, undoJob } from "/static/job.js";
import { big } from "/static/machine.js";
import { hasWebs } from "/static/webs.js";
import { VIEWS, webs } from "/static/views.js";

const STEPS = { 1: "open", 2: "parts", 3: "correct", 4: "see", 5: "machine", a: "analyse", h: "history" };
const isTyping = ({ tagName, type }) => tagName === "TEXTAREA" || tagName === "SELECT" || (tagName === "INPUT" && type !== "range" && type !== "checkbox");

export function setUp(view) {
  document.addEventListener("keydown", (event) => {
    if (document.querySelector("dialog[open]")) return;
    if ((event.ctrlKey || event.metaKey) && event.key === "Enter") {
      document.activeElement?.blur(); // what is being typed counts
      document.querySelector(".line button.main, .first button.main")?.click();
      event.preventDefault();
      return;
    }
    if (isTyping(event.target)) return;
    const back = (event.ctrlKey || event.metaKey) && !event.defaultPrevented && { z: event.shiftKey ? redoJob : undoJob, Z: redoJob, y: redoJob }[event.key];
    if (back && back()) event.preventDefault();
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const key = event.key.toLowerCase(), turn = VIEWS.find(([, , letter]) => letter === key);
    if (STEPS[key]) emit("tab", STEPS[key]);
    else if (turn) view.toView(turn);
    else if (key === "w" && hasWebs()) webs();
    else if (key === "b" && state.result) { emit("tab", "machine"); big.value = true; }
    else if (key === "p") $("downloads")?.querySelector("[data-file='sheet.pdf']")?.click();
    else return;
    event.preventDefault();
  });
}
