// Help of the field that has the focus, in a line of its own at the foot of the panel: nothing moves by it.
import { $ } from "/static/tools.js";

export function setUp() {
  document.addEventListener("focusin", ({ target }) => {
    const help = (target.getAttribute("aria-describedby") || "").split(" ").map($).find((each) => each?.classList.contains("help"));
    $("help-line").textContent = help ? help.textContent : target.title || "";
  });
}
