// What stands of moved cuts: a box at the top of the panel, and sliders.
import { html } from "/static/preact.min.js";
import { $, shown, withUnit } from "/static/tools.js";
import { TURN, TURN_STEP, angleOf, anyElsewhere, anyMoved, asItWas, cuts, drill, dragged, isMoved, redo, set, someAlike, steps, trial, undo } from "/static/drag.js";
import { isAdded } from "/static/cuts.js";
import { most } from "/static/handles.js";
import { Predicted } from "/static/measured.js";
import { mount, redraw } from "/static/store.js";
import { unitOf } from "/static/units.js";
import { angleText, sign } from "/static/zero.js";
import { t } from "/static/words.js";

export function setUp() {
  mount(Box, $("dragged-root"));
}

// --- at the top of the panel -------------------------------------------------------------------------------------------

function Box() {
  const { undone, redone } = steps(), place = dragged.gripped;
  return html`<div id="dragged" data-testid="dragged" role="group" aria-label=${t("Dragged cuts")} hidden=${!anyMoved()}>
    <p class="quiet">${t("Predicted, not yet cut")}</p><${Left} id="dragged-says"/><${Walls}/>
    ${place >= 0 && cuts()[place]?.drills.length > 1 ? html`<${Drill} place=${place} id="gripped-drill"/>` : ""}<${Together}/>
    <p class="buttons"><button type="button" id="try-dragged" data-testid="try-dragged" hidden=${dragged.verb !== "balance"} onClick=${trial}>${t("Cut and measure")}</button> <button type="button" id="undo-dragged" onClick=${asItWas}>${t("Reset")}</button> <button type="button" id="undo" data-testid="undo" disabled=${!undone} aria-label=${t("Undo")} onClick=${undo}>↶</button> <button type="button" id="redo" data-testid="redo" disabled=${!redone} aria-label=${t("Redo")} onClick=${redo}>↷</button></p></div>`;
}

// Depths end where the walls of a hole's own place and drill do; of another place or drill nobody has looked at them.
const Walls = () => (anyElsewhere() ? html`<p class="quiet walls">${t("Walls at other angles and of other drills are checked when they are cut")}</p>` : "");

function Together() {
  if (!someAlike()) return "";
  return html`<label class="check"><input type="checkbox" data-testid="together" checked=${dragged.together} onInput=${({ target }) => { dragged.together = target.checked; redraw(); }}/> ${t("with the equal cuts in other webs")}</label>`;
}

function Drill({ place, id }) {
  const { drills, number } = cuts()[place];
  return html`<label class="one-line">${t("Drill of cut {number}", { number })} <select id=${id} value=${String(dragged.diameters[place])} onInput=${({ target }) => drill(place, Number(target.value))}>${drills.map((each) => html`<option value=${String(each.diameter_mm)}>${`⌀ ${withUnit(each.diameter_mm, 2, "mm")}${each.drill ? `, ${each.drill}` : ""}`}</option>`)}</select></label>`;
}

// --- what is left, and where the moved cuts are ----------------------------------------------------------------

const FACTS = (left) => [["Residual", "residual.magnitude_g_mm", left.magnitude_g_mm, "g·mm", 3], ...left.planes.map((plane, k) => [`Plane ${plane.name}`, `residual.planes.${k}.magnitude_g_mm`, plane.magnitude_g_mm, "g·mm", 3]), ["Of permitted", "worst_share", left.worst_share, "%", 1], ["Mass", "mass_change_g", left.mass_change_g, "g", 2], ["Inertia", "inertia_change_kg_mm2", left.inertia_change_kg_mm2, "kg·mm²", 3]];

function Left({ id }) {
  const { left, busy } = dragged, isWithin = left ? left.worst_share <= 1 : undefined;
  return html`<dl id=${id} data-testid=${id} aria-live="polite" aria-busy=${busy ? "true" : undefined} data-within=${left ? String(isWithin) : undefined}>
    ${left ? html`<dt>${t("Verdict")}</dt><dd class="turned">${t(isWithin ? "Within tolerance" : "Above tolerance")}</dd>${FACTS(left).map(([name, , value, unit, digits]) => html`<dt>${t(name)}</dt><dd><${Predicted} value=${value} digits=${digits} unit=${unit}/> ${unitOf(unit)}</dd>`)}<${Moved}/>` : ""}</dl>`;
}

// Angle, depth and drill of every cut that was moved.
function Moved() {
  return cuts().flatMap((cut, place) => (isMoved(place) ? [html`<dt>${t("Cut {number}", { number: cut.number })}</dt><dd>${angleText(angleOf(place))} ${sign()}, ${withUnit(dragged.depths[place], 2, "mm")} ${isAdded(cut) ? t("high") : t("deep")}${cut.drills.length > 1 ? `, ⌀ ${withUnit(dragged.diameters[place], 2, "mm")}` : ""}</dd>`] : []));
}

// --- beside the model -----------------------------------------------------------------------------------------

export function Panel() {
  const { verb } = dragged;
  return html`<details id="drag-box" data-testid="drag" hidden=${!cuts().length}><summary>${t("Drag depths and holes")} <small>${t("predicted: a linear model about this result")}</small></summary>
    <div id="drags">${cuts().map((cut, place) => html`<${Sliders} key=${cut.number} cut=${cut} place=${place}/>`)}</div><${Left} id="predictions"/><${Walls}/>
    <p class="buttons"><button type="button" id="try-depths" data-testid="try-depths" hidden=${verb !== "balance"} onClick=${trial}>${t("Cut and measure")}</button> <button type="button" id="undo-depths" onClick=${asItWas}>${t("Reset")}</button></p></details>`;
}

function Sliders({ cut, place }) {
  const top = most(cut), depth = dragged.depths[place], turn = dragged.turns[place];
  return html`<fieldset class="drag"><legend>${cut.number}. ${cut.label}</legend>
    <${Slider} words=${isAdded(cut) ? t("Height") : t("Depth")} label=${`${isAdded(cut) ? t("Height of cut {number}", { number: cut.number }) : t("Depth of cut {number}", { number: cut.number })} [mm]`} min=${0} max=${top} step=${cut.depth_step_mm || top / 400} value=${depth} says=${withUnit(depth, 2, "mm")} change=${(value) => set(place, value, dragged.turns[place])}/>
    ${cut.may_turn ? html`<${Slider} words=${t("Turn about the axis")} label=${`${t("Turn cut {number} about the axis", { number: cut.number })} [°]`} min=${-TURN} max=${TURN} step=${TURN_STEP} value=${turn} says=${`${shown(turn, 1)}°`} change=${(value) => set(place, dragged.depths[place], value)}/>` : ""}
    ${cut.drills.length > 1 ? html`<${Drill} place=${place} id=${`drill-${cut.number}`}/>` : ""}</fieldset>`;
}

const Slider = ({ words, label, min, max, step, value, says, change }) => html`<label class="slider"><span>${words}</span><output>${says}</output><input type="range" min=${min} max=${max} step=${step} value=${value} aria-label=${label} onInput=${({ target }) => change(Number(target.value))}/></label>`;
