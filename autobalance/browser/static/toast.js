// A word about what happened elsewhere: it goes by itself.
import { html } from "/static/preact.min.js";
import { signal } from "/static/store.js";

const said = signal("");
const STAYS_MS = 10000;
let ends = 0;

export function toast(words) {
  said.value = words;
  clearTimeout(ends);
  ends = setTimeout(() => { said.value = ""; }, STAYS_MS);
}
export const Toast = () => html`<p class="toast" aria-live="polite" data-testid="toast">${said.value}</p>`;
