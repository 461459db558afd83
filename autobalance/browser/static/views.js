// Views of the crank at a press: from aside, and square on from both ends and from the side, so that angles can be read.
import { html } from "/static/preact.min.js";
import { $ } from "/static/tools.js";
import { mount } from "/static/store.js";
import { hasWebs, isShown } from "/static/webs.js";
import { t } from "/static/words.js";

// Each with its key.
export const VIEWS = [["3D", null, "f"], ["Front", [0, 0, -1], "e"], ["Rear", [0, 0, 1], "r"], ["Side", [0, 1, 0], "s"]];
const TITLES = [() => t("The whole crank from aside. Key: F"), () => t("Square on from the front end: angles can be read. Key: E"), () => t("Square on from the rear end: angles can be read. Key: R"), () => t("Square on from the side. Key: S")];

export function setUp(view) {
  view.toView = ([, way]) => { isShown.value = false; if (way) view.turnTo(way, null); else if (view.sets[view.mode]) view.look(); };
  mount(() => html`${VIEWS.map((each, k) => html`<button type="button" title=${TITLES[k]()} aria-keyshortcuts=${each[2]} onClick=${() => view.toView(each)}>${t(each[0])}</button>`)}${hasWebs() ? html`<button type="button" data-testid="view-webs" title=${t("Each web that is cut, on one degree wheel; the shop sheet has the same drawing. Key: W")} aria-keyshortcuts="w" aria-pressed=${String(isShown.value)} onClick=${webs}>${t("Webs")}</button>` : ""}`, $("views"));
}
// The webs in place of the model, and back.
export const webs = () => { isShown.value = !isShown.value; };
