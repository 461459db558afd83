// Help of the field that has the focus, in a line of its own at the foot of the panel: nothing moves by it.
import { HELP } from "/static/keys.js";
import { mount, signal } from "/static/store.js";
import { $ } from "/static/tools.js";
import { t } from "/static/words.js";

// A click on a number takes all of it: what is typed next takes its place. A second click sets the caret.
let fresh = null;
document.addEventListener("mousedown", ({ target }) => { fresh = target.matches?.("input[inputmode=decimal]") && target !== document.activeElement ? target : null; });
document.addEventListener("mouseup", ({ target }) => { if (fresh && fresh === target && target.selectionStart === target.selectionEnd) target.select(); fresh = null; });

const focused = signal(""); // what helps with the field that has the focus; without one, what the step is for stands there

export function setUp() {
  mount(() => focused.value || t(HELP[document.body.dataset.tab] || ""), $("help-line"));
  document.addEventListener("focusin", ({ target }) => {
    const help = (target.getAttribute("aria-describedby") || "").split(" ").map($).find((each) => each?.classList.contains("help"));
    focused.value = help ? help.textContent : target.title || "";
  });
}
