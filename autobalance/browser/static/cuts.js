// Cuts, in the order of indexing: where each cut is, how deep; a row turns the view to it.
import { html } from "/static/preact.min.js";
import { Measured } from "/static/measured.js";
import { emit, state } from "/static/job.js";
import { shown } from "/static/tools.js";
import { manyWords, nounOf } from "/static/kind-cards.js";
import { kinds } from "/static/limits.js";
import { redrawNow } from "/static/store.js";
import { unitOf } from "/static/units.js";
import { angleText, sign as signOf, zeroWords } from "/static/zero.js";
import { locale, t } from "/static/words.js";

let chosen = null;
export const isAdded = (cut) => Boolean(kinds.of(cut.kind)?.adds);

// Which way the tool comes from, as a unit vector out of the metal.
export function outOf(cut) {
  if (cut.inward) return cut.inward.map((each) => -each);
  return cut.side ? [0, 0, cut.side] : [cut.position_mm[0], cut.position_mm[1], 0];
}
// The set-up in which a cut is made, by the letter that sheet, list of holes and NC programs have.
const SIDES = { T: "from +z", B: "from \u2212z", R: "from the rim", L: "round the rim" };
const AXIAL = 0.9; // of a result from elsewhere, which has no letters: component along the axis from which a tool comes from an end
function letterOf(cut) {
  const k = (state.result?.report.corrections || []).indexOf(cut), told = state.result?.setups?.[k];
  if (told !== undefined) return told;
  const along = outOf(cut)[2];
  return "new_radius_mm" in cut ? "L" : Math.abs(along) > AXIAL ? (along > 0 ? "T" : "B") : "R";
}
export const enteredFrom = (cut) => t(SIDES[letterOf(cut)] || "all over");
function turnTo(cut) {
  chosen = cut;
  emit("look", outOf(cut));
  redrawNow();
}

// A cut of a result in words: its kind and size, its web, its angle from the zero of the job.
export function cutWords({ number, kind, web, diameter_mm: wide }) {
  const made = state.result?.report.corrections.find((each) => each.number === number);
  return [`${nounOf(kind)}${wide ? ` ⌀${shown(wide, 2, "mm")}` : ""}`, web ? `${t("web")} ${web}` : "", typeof made?.angle_deg === "number" ? `${angleText(made.angle_deg)} ${signOf()}` : ""].filter(Boolean).join(", ");
}
// When a cut was ticked as done, with a sign.
export const doneAt = ({ number }) => `✓ ${t("done {time}", { time: new Date(state.ticks[number]).toLocaleString(locale, { dateStyle: "short", timeStyle: "short" }) })}`;
// Cuts have a depth; metal that is added has a height, and a table of its own.
export function Cuts({ id, corrections, title = "" }) {
  const all = corrections.map((cut, k) => [cut, k]), [cuts, pads] = [all.filter(([cut]) => !isAdded(cut)), all.filter(([cut]) => isAdded(cut))];
  if (!all.length) return html`<table id=${id} hidden><tbody></tbody></table>`;
  return html`${cuts.length ? html`<${Table} id=${id} title=${title || t("What to cut")} head=${t("cut")} far=${t("depth")} says=${id} cuts=${cuts}/>` : ""}${pads.length ? html`<${Table} id=${`${id}-added`} title=${t("Metal to add")} head=${t("pad")} far=${t("height")} says=${id} cuts=${pads}/>` : ""}
    <p class="quiet" id=${`${id}-says`}><span data-testid="zero">${zeroWords()}</span>. ${t("The radius of a hole is at its entry. Choose a row, and the view turns to it.")}</p>`;
}
function Table({ id, title, head, far, says, cuts }) {
  const mm = unitOf("mm"), heads = [[t("No.")], [head], [t("angle")], [t("radius"), mm], [far, mm]];
  return html`<table id=${id} class="cuts" aria-describedby=${`${says}-says`}><caption>${title}</caption>
    <thead><tr>${heads.map(([name, unit]) => html`<th scope="col">${name}${unit ? html`<br/>[${unit}]` : ""}</th>`)}</tr></thead>
    ${grouped(cuts).map((group) => html`<tbody key=${group.title} data-setup=${group.letter} data-web=${String(group.web ?? "")}><tr class="group"><th colspan="5" scope="colgroup">${group.title} <small>${group.says}</small></th></tr>${group.cuts.map(([cut, k]) => html`<${Row} key=${cut.number} cut=${cut} path=${`corrections.${k}`} onPaper=${state.result?.radii?.[k]}/>`)}</tbody>`)}</table>`;
}

// Cuts by the set-up in which they are made, and by web, in the order of their numbers.
function grouped(cuts) {
  const groups = new Map(), letters = [...new Set(cuts.map(([cut]) => letterOf(cut)))];
  for (const [cut, k] of cuts) {
    const letter = letterOf(cut), name = `${letter} ${cut.web ?? ""}`;
    if (!groups.has(name)) groups.set(name, { letter, web: cut.web, cuts: [] });
    groups.get(name).cuts.push([cut, k]);
  }
  const list = [...groups.values()].sort((one, other) => letters.indexOf(one.letter) - letters.indexOf(other.letter));
  const place = ({ letter, cuts: [[first]] }) => (letter ? t("Set-up {letter}: {side}", { letter, side: enteredFrom(first) }) : enteredFrom(first));
  return list.map((group) => ({ ...group, title: `${place(group)}${group.web ? `, ${t("web")} ${group.web}` : ""}`, says: manyWords(group.cuts.every(([cut]) => cut.kind === group.cuts[0][0].kind) ? group.cuts[0][0].kind : "", group.cuts.length) }));
}

// The radius that the papers have: of a hole on its rim's own circle.
function Row({ cut, path, onPaper }) {
  const radius = cut.entry_radius_mm === undefined || cut.entry_radius_mm === null ? "radius_mm" : "entry_radius_mm";
  const figure = (key, digits, sign = 1) => html`<${Measured} of=${`${path}.${key}`} value=${cut[key]} digits=${digits} sign=${sign}/>`, sign = isAdded(cut) ? -1 : 1;
  return html`<tr class="turns" aria-selected=${String(chosen === cut)} onClick=${() => turnTo(cut)}>
    <th scope="row"><button type="button" aria-label=${t("Cut {number}: turn the view to it", { number: cut.number })} data-testid="turn-to" data-cut=${String(cut.number)}>${cut.number}</button></th>
    <td class="words">${nounOf(cut.kind)}<small>${cut.diameter_mm ? html`⌀${figure("diameter_mm", 2)}, ` : ""}z ${figure("z_mm", 2)}</small>${state.ticks[cut.number] ? html`<small data-testid="tick" data-at=${state.ticks[cut.number]}>${doneAt(cut)}</small>` : ""}</td><td class="num"><span data-key=${`${path}.angle_deg`} data-value=${String(cut.angle_deg)}>${angleText(cut.angle_deg)}</span><small class="ref"> ${signOf()}</small></td>
    <td>${typeof onPaper === "number" ? html`<span data-radius=${String(onPaper)}>${shown(onPaper, 2, "mm")}</span>` : figure(radius, 2)}</td><td><b>${figure("depth_mm", 3, sign)}</b><small>${figure("removed_mass_g", 2, sign)} g${sign < 0 ? ` ${t("on")}` : ""}</small></td></tr>`;
}
