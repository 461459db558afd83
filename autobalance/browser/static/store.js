// Components on the page: all that are mounted are drawn again, once, after anything they show has changed.
import { html, render } from "/static/preact.min.js";

const drawn = [];
let waiting = false;

export function mount(component, box) {
  const draw = () => render(html`<${component}/>`, box);
  drawn.push(draw);
  draw();
}
export function redraw() {
  if (waiting) return;
  waiting = true;
  queueMicrotask(redrawNow);
}
export function redrawNow() {
  waiting = false;
  for (const draw of drawn) draw();
}
// A value that components show.
export function signal(value) {
  return { get value() { return value; }, set value(next) { if (next !== value) { value = next; redraw(); } } };
}
