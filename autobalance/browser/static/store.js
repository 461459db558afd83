// Components on the page: all that are mounted are drawn again, once, after anything they show has changed.
import { html, render } from "/static/preact.min.js";

const drawn = [];
let waiting = false;

export function mount(component, box) {
  const draw = () => render(html`<${component}/>`, box);
  drawn.push({ draw, box });
  draw();
}
export function redraw() {
  if (waiting) return;
  waiting = true;
  queueMicrotask(redrawNow);
}
export function redrawNow() {
  waiting = false;
  for (const { draw } of drawn) draw();
}
// While a hand drags: at once what is on the open tab, the rest when the hand rests.
const REST_MS = 150;
let resting = null;
export function redrawSeen() {
  for (const { draw, box } of drawn) if (!box.closest("[hidden]")) draw();
  clearTimeout(resting);
  resting = setTimeout(redraw, REST_MS);
}
// A value that components show.
export function signal(value) {
  return { get value() { return value; }, set value(next) { if (next !== value) { value = next; redraw(); } } };
}
