// Views of the crank at a press: from aside, and square on from both ends and from the side, so that angles can be read.
import { html } from "/static/preact.min.js";
import { $ } from "/static/tools.js";
import { mount } from "/static/store.js";
import { t } from "/static/words.js";

const WAYS = [["3D", null], ["Front", [0, 0, -1]], ["Rear", [0, 0, 1]], ["Side", [0, 1, 0]]];

export function setUp(view) {
  const turn = (way) => { if (way) view.turnTo(way, null); else if (view.sets[view.mode]) view.look(); };
  mount(() => html`${WAYS.map(([words, way]) => html`<button type="button" onClick=${() => turn(way)}>${t(words)}</button>`)}`, $("views"));
}
