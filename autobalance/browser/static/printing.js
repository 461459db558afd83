// The page on paper: a copy of the model as it is seen, for what a graphics card drew is not printed.
import { $ } from "/static/tools.js";

export function setUp(view) {
  window.addEventListener("beforeprint", () => {
    if (!view.renderer || !view.sets[view.mode] || !$("canvas").width) return;
    view.drawn(); // a copy can be taken only in the task that drew it
    const copy = $("printed"), { width, height } = $("canvas");
    Object.assign(copy, { width, height });
    copy.getContext("2d").drawImage($("canvas"), 0, 0);
  });
}
