// Views of the crank at a press: all of it, along its axis, at crankpin 1, at the counterweight, from above.
import { html } from "/static/preact.min.js";
import { $ } from "/static/tools.js";
import { mount } from "/static/store.js";
import { t } from "/static/words.js";

const WAYS = [["Fit", null], ["+z", [0, 0, 1]], ["\u2212z", [0, 0, -1]], ["crankpin 1", [1, 0, 0.001]], ["counterweight", [-1, 0, 0.001]]];

export function setUp(view) {
  const turn = (way) => { if (way) view.turnTo(way); else if (view.sets[view.mode]) view.look(); };
  mount(() => html`${WAYS.map(([words, way]) => html`<button type="button" onClick=${() => turn(way)}>${t(words)}</button>`)}`, $("views"));
}
