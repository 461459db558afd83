// A word about what happened elsewhere: it goes by itself.
import { html } from "/static/preact.min.js";
import { signal } from "/static/store.js";

const said = signal({ words: "", act: null });
const STAYS_MS = 10000;
let ends = 0;

// Words, and what may be done about it: { words, work }.
export function toast(words, act = null) {
  said.value = { words, act };
  clearTimeout(ends);
  ends = setTimeout(gone, STAYS_MS);
}
const gone = () => { said.value = { words: "", act: null }; };
export function Toast() {
  const { words, act } = said.value;
  return html`<p class="toast" aria-live="polite" data-testid="toast" data-empty=${String(!words)}>${words}${act ? html` <button type="button" data-testid="toast-act" onClick=${() => { gone(); act.work(); }}>${act.words}</button>` : ""}</p>`;
}
export { STAYS_MS };
