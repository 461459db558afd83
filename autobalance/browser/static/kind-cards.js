// Kinds of correction as cards: where each takes the metal, and what it would leave on this crank.
import { html } from "/static/preact.min.js";
import { compared, pictured } from "/static/board.js";
import { changed } from "/static/job.js";
import { chosen, kinds, listed, methods } from "/static/limits.js";
import { Measured } from "/static/measured.js";
import { shown, withUnit } from "/static/tools.js";
import { t } from "/static/words.js";

const METAL = "M44 20A16 16 0 0 1 76 20L80 36 96 40A36 36 0 0 1 24 40L40 36Z";
const PICTURES = {
  shoulder: html`<path class="k-cut" d="M27.2 55H92.8A36 36 0 0 1 27.2 55Z"/>`,
  turn: html`<path class="k-line" d="M28.5 50A33 33 0 0 0 91.5 50"/>`,
  drill: [[36.6, 67.9, 46.2, 56.4], [47.6, 74.2, 52.7, 60.1], [60, 76.4, 60, 61.4], [72.4, 74.2, 67.3, 60.1], [83.4, 67.9, 73.8, 56.4]].map(([x, y, u, v]) => html`<path class="k-line" d=${`M${x} ${y}L${u} ${v}`}/>`),
  slug: [[43, 62], [60, 68], [77, 62]].map(([x, y]) => html`<circle class="k-slug" cx=${x} cy=${y} r="5.5"/>`),
  add: html`<path class="k-more" d="M43 17A17.5 17.5 0 0 1 77 17"/>`,
  mill: html`<rect class="k-cut" x="42" y="56" width="36" height="12" rx="3"/>`,
};
const NAMES = { shoulder: "Shoulder", turn: "Turn", drill: "Drill", slug: "Slug", add: "Add", mill: "Mill" };
// What a kind does, where its noun would only repeat its name.
const MEANS = { shoulder: "Face milled off the web", slug: "Heavy metal in a bore" };
// What a shop calls a kind, and one of its cuts: the noun that all papers have.
export const kindWords = (name) => t(NAMES[name] || name);
export const nounOf = (name) => t(kinds.of(name)?.noun || name);
const ONTO = { add: "on" };
const MANY = { drill: "holes: {count}", slug: "slugs: {count}", mill: "pockets: {count}", add: "pads: {count}" };
export const manyWords = (kind, count) => t(MANY[kind] || "cuts: {count}", { count });
const isWithin = (row) => row.outcome === "within_tolerance" || row.outcome === "already_within_tolerance";

export function KindCards() {
  return html`<div class="kinds" role="radiogroup" aria-label=${t("Kind of cut")} data-testid="kinds">${kinds.list.map(({ name, noun }) => html`<${Card} key=${name} name=${name} noun=${noun}/>`)}</div>`;
}

function Card({ name, noun }) {
  const isChosen = !listed.cuts && !chosen.also && chosen.method === name, found = compared([name]);
  const take = () => { Object.assign(chosen, { method: name, also: "", others: [] }); listed.cuts = null; changed(); };
  return html`<button type="button" class=${`kind${isChosen ? " chosen" : ""}`} role="radio" aria-checked=${String(isChosen)} data-kind=${name} data-testid=${`kind-${name}`} data-old=${String(Boolean(found?.isOld))} onClick=${take} onMouseEnter=${() => pictured(name)} onMouseLeave=${() => pictured("")} onFocusIn=${() => pictured(name)} onFocusOut=${() => pictured("")}>
    <svg viewBox="0 0 120 86" aria-hidden="true"><path class="k-metal" d=${METAL}/>${PICTURES[name]}<circle class="k-pin" cx="60" cy="18" r="6.5"/><circle class="k-journal" cx="60" cy="40" r="7.5"/></svg>
    <span class="top"><b>${t(NAMES[name] || noun)}</b>${found ? html`<${Badge} ...${found}/>` : ""}</span><span class="says">${found ? html`<${Says} name=${name} ...${found}/>` : t(MEANS[name] || noun)}</span></button>`;
}

function Badge({ row, place, isOld }) {
  const tone = isOld ? "stale" : !row.outcome ? "plain" : isWithin(row) ? "good" : "bad", sign = { good: "✓ ", bad: "✕ ", stale: "◷ ", plain: "" }[tone];
  return html`<span class="badge" data-tone=${tone}>${sign}${row.outcome ? html`<${Measured} of=${`rows.${place}.residual_g_mm`} value=${row.residual_g_mm} digits=${row.residual_g_mm < 100 ? 2 : 0}/>` : "–"}</span>`;
}
function Says({ name, row, place, isBest }) {
  if (!row.outcome) return t("no place on this crank");
  const wall = row.wall_left_mm;
  return html`${isBest ? html`<b>${t("Recommended")}</b>, ` : ""}<b>${manyWords(name, row.cuts)}</b>, <${Measured} of=${`rows.${place}.metal_moved_g`} value=${row.metal_moved_g} digits=${1}/> g ${t(ONTO[name] || "off")}<br/>${wall === null || wall === undefined ? t("no thin wall") : t("wall left {wall}", { wall: withUnit(wall, 1, "mm") })}`;
}
// What the chosen method would leave, as it was compared, for the state line; null where it was not.
export function plannedSays() {
  const found = listed.cuts ? null : compared(methods());
  if (!found?.row.outcome || found.isOld) return null;
  return { left: found.row.residual_g_mm, words: `${t("Plan: {method}", { method: methods().map(kindWords).join(" + ") })}, ${manyWords(chosen.also ? "" : chosen.method, found.row.cuts)}`, says: t("Compared: {left} is left, {mass} moved. Cut and measured next.", { left: withUnit(found.row.residual_g_mm, 2, "g·mm"), mass: `${shown(found.row.metal_moved_g, 1)} g` }) };
}
