// Help of the field that has the focus, in a line of its own at the foot of the panel: nothing moves by it.
import { $ } from "/static/tools.js";

// A click on a number takes all of it: what is typed next takes its place. A second click sets the caret.
let fresh = null;
document.addEventListener("mousedown", ({ target }) => { fresh = target.matches?.("input[inputmode=decimal]") && target !== document.activeElement ? target : null; });
document.addEventListener("mouseup", ({ target }) => { if (fresh && fresh === target && target.selectionStart === target.selectionEnd) target.select(); fresh = null; });

export function setUp() {
  document.addEventListener("focusin", ({ target }) => {
    const help = (target.getAttribute("aria-describedby") || "").split(" ").map($).find((each) => each?.classList.contains("help"));
    $("help-line").textContent = help ? help.textContent : target.title || "";
  });
}
