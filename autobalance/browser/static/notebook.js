// The view in a notebook: a crank, or a result with its slider from before to after, and a section.
import { View } from "/static/view.js";

function label(words, input) {
  const made = document.createElement("label");
  made.append(words, input);
  return made;
}
function slider(value) {
  return Object.assign(document.createElement("input"), { type: "range", min: 0, max: 100, value });
}

function render({ model, el }) {
  const box = document.createElement("div"), canvas = document.createElement("canvas"), note = document.createElement("p"), tools = document.createElement("div");
  box.className = "autobalance-view"; tools.className = "autobalance-tools"; box.tabIndex = 0;
  box.setAttribute("role", "img");
  box.setAttribute("aria-label", "The crank: arrow keys turn it, plus and minus zoom");
  box.append(canvas, note);
  el.append(box, tools);
  const view = new View(box, canvas, note);
  box.view = view;
  const sent = model.get("data"), buffer = sent.buffer.slice(sent.byteOffset, sent.byteOffset + sent.byteLength);
  if (model.get("kind") === "result") {
    view.showResult(buffer);
    const fade = slider(100);
    fade.addEventListener("input", () => view.fade(1 - Number(fade.value) / 100));
    view.fade(0);
    tools.append(label("before to after ", fade));
  } else view.showCrank(buffer);
  const axis = document.createElement("select"), place = slider(50);
  for (const name of ["none", "x", "y", "z"]) axis.append(Object.assign(document.createElement("option"), { value: name, textContent: name }));
  for (const each of [axis, place]) each.addEventListener("input", () => view.section(axis.value, Number(place.value) / 100));
  tools.append(label("section ", axis), label("at ", place));
}

export default { render };
