// Cuts, in the order of indexing: where each cut is, how deep; a row turns the view to it.
import { html } from "/static/preact.min.js";
import { Measured } from "/static/measured.js";
import { emit, state } from "/static/job.js";
import { shown } from "/static/tools.js";
import { manyWords } from "/static/kind-cards.js";
import { redrawNow } from "/static/store.js";
import { unitOf } from "/static/units.js";
import { angleText, sign, zeroWords } from "/static/zero.js";
import { locale, t } from "/static/words.js";

let chosen = null;
const CUTS = { drill: "Hole", slug: "Slug", shoulder: "Face", turn: "Rim", add: "Pad", mill: "Pocket" };

// Which way the tool comes from, as a unit vector out of the metal.
export function outOf(cut) {
  if (cut.inward) return cut.inward.map((each) => -each);
  return cut.side ? [0, 0, cut.side] : [cut.position_mm[0], cut.position_mm[1], 0];
}
export function enteredFrom(cut) {
  const along = outOf(cut)[2];
  return Math.abs(along) > 0.9 ? (along > 0 ? "+z" : "−z") : t("rim");
}
function turnTo(cut) {
  chosen = cut;
  emit("look", outOf(cut));
  redrawNow();
}

// When a cut was ticked as done, with a sign.
export const doneAt = ({ number }) => `✓ ${t("done {time}", { time: new Date(state.ticks[number]).toLocaleString(locale, { dateStyle: "short", timeStyle: "short" }) })}`;
export function Cuts({ id, corrections, title = "" }) {
  if (!corrections.length) return html`<table id=${id} hidden><tbody></tbody></table>`;
  const mm = unitOf("mm"), heads = [[t("No.")], [t("cut")], [t("angle")], [t("radius"), mm], [t("depth"), mm]];
  return html`<table id=${id} class="cuts" aria-describedby=${`${id}-says`}><caption>${title || t("What to cut")}</caption>
    <thead><tr>${heads.map(([name, unit]) => html`<th scope="col">${name}${unit ? html`<br/>[${unit}]` : ""}</th>`)}</tr></thead>
    ${grouped(corrections).map((group) => html`<tbody key=${group.title} data-setup=${group.from} data-web=${String(group.web ?? "")}><tr class="group"><th colspan="5" scope="colgroup">${group.title} <small>${group.says}</small></th></tr>${group.cuts.map(([cut, k]) => html`<${Row} key=${cut.number} cut=${cut} path=${`corrections.${k}`} onPaper=${state.result?.radii?.[k]}/>`)}</tbody>`)}</table>
    <p class="quiet" id=${`${id}-says`}><span data-testid="zero">${zeroWords()}</span>. ${t("The radius of a hole is at its entry. Choose a row, and the view turns to it.")}</p>`;
}

// Cuts by the set-up in which they are made, and by web, in the order of their numbers.
function grouped(corrections) {
  const groups = new Map(), setups = [...new Set(corrections.map(enteredFrom))];
  corrections.forEach((cut, k) => {
    const from = enteredFrom(cut), name = `${setups.indexOf(from)} ${cut.web ?? ""}`;
    if (!groups.has(name)) groups.set(name, { from, web: cut.web, cuts: [] });
    groups.get(name).cuts.push([cut, k]);
  });
  const list = [...groups.values()].sort((one, other) => setups.indexOf(one.from) - setups.indexOf(other.from));
  return list.map((group) => ({ ...group, title: `${t("Set-up {number}: from {side}", { number: setups.indexOf(group.from) + 1, side: group.from })}${group.web ? `, ${t("web")} ${group.web}` : ""}`, says: manyWords(group.cuts.every(([cut]) => cut.kind === group.cuts[0][0].kind) ? group.cuts[0][0].kind : "", group.cuts.length) }));
}

// The radius that the papers have: of a hole on its rim's own circle.
function Row({ cut, path, onPaper }) {
  const radius = cut.entry_radius_mm === undefined || cut.entry_radius_mm === null ? "radius_mm" : "entry_radius_mm";
  const figure = (key, digits) => html`<${Measured} of=${`${path}.${key}`} value=${cut[key]} digits=${digits}/>`;
  return html`<tr class="turns" aria-selected=${String(chosen === cut)} onClick=${() => turnTo(cut)}>
    <th scope="row"><button type="button" aria-label=${t("Cut {number}: turn the view to it", { number: cut.number })} data-testid="turn-to" data-cut=${String(cut.number)}>${cut.number}</button></th>
    <td class="words">${t(CUTS[cut.kind] || cut.kind)}<small>${cut.diameter_mm ? html`⌀${figure("diameter_mm", 2)}, ` : ""}z ${figure("z_mm", 2)}</small>${state.ticks[cut.number] ? html`<small data-testid="tick" data-at=${state.ticks[cut.number]}>${doneAt(cut)}</small>` : ""}</td><td class="num"><span data-key=${`${path}.angle_deg`} data-value=${String(cut.angle_deg)}>${angleText(cut.angle_deg)}</span><small class="ref"> ${sign()}</small></td>
    <td>${typeof onPaper === "number" ? html`<span data-radius=${String(onPaper)}>${shown(onPaper, 2, "mm")}</span>` : figure(radius, 2)}</td><td><b>${figure("depth_mm", 3)}</b><small>${figure("removed_mass_g", 2)} g</small></td></tr>`;
}
