// What stands of moved cuts: a box at the top of the panel, fields and sliders.
import { html } from "/static/preact.min.js";
import { $, shown, typed, withUnit } from "/static/tools.js";
import { state } from "/static/job.js";
import { TURN, TURN_STEP, angleOf, anyElsewhere, anyMoved, asItWas, cuts, drill, dragged, isMoved, redo, set, someAlike, stepped, steps, trial, undo } from "/static/drag.js";
import { cutWords, isAdded } from "/static/cuts.js";
import { most } from "/static/handles.js";
import { Predicted } from "/static/measured.js";
import { mount, redraw, signal } from "/static/store.js";
import { fromShown, toShown, unitOf } from "/static/units.js";
import { angleText, fromZero, sign, zeroDeg, zeroWords } from "/static/zero.js";
import { t } from "/static/words.js";

export function setUp() {
  mount(Box, $("dragged-root"));
}

// --- at the top of the panel -------------------------------------------------------------------------------------------

function Box() {
  const { undone, redone } = steps(), place = dragged.gripped, cut = cuts()[place], isMovedYet = anyMoved();
  return html`<div id="dragged" data-testid="dragged" role="group" aria-label=${t("Dragged cuts")} hidden=${!isMovedYet && !cut}>
    ${cut ? html`<h3>${t("Cut {number}", cut)} <small>${cutWords(cut)}</small></h3><${Numbers} cut=${cut} place=${place} of="gripped"/><${Together}/>` : ""}
    <div hidden=${!isMovedYet}><p class="quiet">${t("Predicted, not yet cut")}</p><${Left} id="dragged-says"/><${Walls}/></div>${cut ? "" : html`<${Together}/>`}
    <p class="buttons"><button type="button" id="try-dragged" data-testid="try-dragged" hidden=${dragged.verb !== "balance" || !isMovedYet} onClick=${trial}>${t("Cut and measure")}</button> <button type="button" id="undo-dragged" onClick=${asItWas}>${t("Reset")}</button> <button type="button" id="undo" data-testid="undo" disabled=${!undone} aria-label=${t("Undo")} onClick=${undo}>↶</button> <button type="button" id="redo" data-testid="redo" disabled=${!redone} aria-label=${t("Redo")} onClick=${redo}>↷</button></p></div>`;
}

// Depths end where the walls of a hole's own place and drill do; of another place or drill nobody has looked at them.
const Walls = () => (anyElsewhere() ? html`<p class="quiet walls">${t("Walls at other angles and of other drills are checked when they are cut")}</p>` : "");

function Together() {
  if (!someAlike()) return "";
  return html`<label class="check"><input type="checkbox" data-testid="together" checked=${dragged.together} onInput=${({ target }) => { dragged.together = target.checked; redraw(); }}/> ${t("with the equal cuts in other webs")}</label>`;
}

// --- numbers of a cut, typed ---------------------------------------------------------------------------------------

const NONE = { id: "", text: "", from: 0 };
const draft = signal(NONE); // what is being typed, from which number, what is wrong with it or to be said of it
const MM = 2, CLOSE_MM = 0.005;
const mm = (value) => shown(value, MM, "mm"), wrapped = (degrees) => (((degrees % 360) + 540) % 360) - 180;

// Depth, angle and drill as fields; below each what it was.
function Numbers({ cut, place, of }) {
  const depth = dragged.depths[place], planned = state.result?.report.corrections[place]?.angle_deg ?? 0, isPad = isAdded(cut), drills = cut.drills.map((each) => each.diameter_mm), now = dragged.diameters[place];
  const stop = (value) => {
    const made = stepped(cut, fromShown(value, "mm"));
    if (made < 0 || made > most(cut) + 1e-9) return { why: t("0 to {most}", { most: withUnit(most(cut), MM, "mm") }) };
    set(place, made, dragged.turns[place], true);
    return Math.abs(made - fromShown(value, "mm")) < 1e-6 ? {} : { says: t("Set to {value}: the depth step is {step}.", { value: withUnit(made, MM, "mm"), step: withUnit(cut.depth_step_mm, MM, "mm") }) };
  };
  const turn = (value) => {
    const by = wrapped(value + zeroDeg() - planned);
    if (Math.abs(by) > TURN + 1e-9) return { why: t("{from} to {to}", { from: angleText(planned - TURN), to: angleText(planned + TURN) }) };
    set(place, dragged.depths[place], Number(by.toFixed(6)), true);
    return {};
  };
  const bit = (value) => {
    const found = drills.find((each) => Math.abs(each - fromShown(value, "mm")) < CLOSE_MM);
    if (found === undefined) return { why: t("Drills of the shop: {drills}.", { drills: drills.map(mm).join("; ") }) };
    if (found !== dragged.diameters[place]) drill(place, found);
    return {};
  };
  const was = (text, isSame) => (isSame ? t("no change") : t("was {value}", { value: text }));
  const step = cut.depth_step_mm || most(cut) / 100, inShown = (value) => toShown(value, "mm");
  return html`<div class="fields numbers">
    <${Typed} id=${`${of}-stop`} words=${`${isPad ? t("Height") : t("Stop at")} [${unitOf("mm")}]`} label=${`${isPad ? t("Height of cut {number}", cut) : t("Depth of cut {number}", cut)} [${unitOf("mm")}]`} says=${t("Depth at which the tool stops, from where it enters the metal")} text=${mm(depth)} note=${was(mm(cut.depth_mm), Math.abs(depth - cut.depth_mm) < 1e-6)} apply=${stop} by=${inShown(step)} now=${inShown(depth)}/>
    ${cut.may_turn ? html`<${Typed} id=${`${of}-angle`} words=${`${t("Angle")} [° ${sign()}]`} label=${`${t("Angle of cut {number}", cut)} [°]`} says=${`${t("Angle about the axis.")} ${zeroWords()}`} text=${angleText(angleOf(place)).replace("°", "")} note=${was(angleText(planned), !dragged.turns[place])} apply=${turn} by=${1} now=${fromZero(angleOf(place))}/>` : ""}
    ${now === null || now === undefined ? "" : html`<${Typed} id=${of === "gripped" ? "gripped-drill" : `drill-${cut.number}`} words=${`${t("Drill")} ⌀ [${unitOf("mm")}]`} label=${`${t("Drill of cut {number}", cut)} [${unitOf("mm")}]`} says=${t("Diameter of the drill, one of those in the job")} text=${mm(now)} note=${drills.length > 1 ? was(mm(cut.diameter_mm), now === cut.diameter_mm) : t("only one")} apply=${bit} now=${toShown(now, "mm")} isFixed=${drills.length < 2} options=${drills.map(mm)}/>`}</div>`;
}

// A number as it is typed: applied as soon as it is one, tidied once the field is left. Arrows move it by a step, with Shift by ten.
function Typed({ id, words, label, says, text, note, apply, by, now, isFixed = false, options }) {
  const own = draft.value.id === id ? draft.value : null;
  // What cannot be leaves the cut where it was before it was typed, not at its first digits.
  const take = (given) => {
    const value = typed(given), from = own ? own.from : now, found = typeof value === "number" ? apply(value) : { why: given.trim() ? t("Enter a number.") : "" };
    if (found.why) apply(from);
    draft.value = { id, text: given, from, ...found };
  };
  const keys = (event) => {
    const way = { ArrowUp: 1, ArrowDown: -1 }[event.key];
    if (event.key === "Enter" || event.key === "Escape") draft.value = NONE;
    else if (way && by) { apply(now + way * by * (event.shiftKey ? 10 : 1)); draft.value = NONE; event.preventDefault(); }
  };
  const wrong = own?.why || "";
  return html`<label>${words}<input id=${id} data-testid=${id} inputMode="decimal" aria-label=${label} title=${says} value=${own ? own.text : text} readOnly=${isFixed} list=${options?.length > 1 ? `${id}-list` : undefined} aria-describedby=${`${id}-note`} aria-invalid=${wrong ? "true" : undefined} onInput=${({ target }) => take(target.value)} onBlur=${() => { if (draft.value.id === id) draft.value = NONE; }} onKeyDown=${keys}/>${options?.length > 1 ? html`<datalist id=${`${id}-list`}>${options.map((each) => html`<option value=${each}/>`)}</datalist>` : ""}<small class=${wrong ? "note" : "quiet"} id=${`${id}-note`}>${wrong || own?.says || note}</small></label>`;
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
  return html`<fieldset class="drag"><legend>${cut.number}. ${cutWords(cut)}</legend><${Numbers} cut=${cut} place=${place} of=${`cut-${cut.number}`}/>
    <${Slider} words=${isAdded(cut) ? t("Height") : t("Depth")} label=${`${isAdded(cut) ? t("Height of cut {number}", { number: cut.number }) : t("Depth of cut {number}", { number: cut.number })} [mm]`} min=${0} max=${top} step=${cut.depth_step_mm || top / 400} value=${depth} says=${withUnit(depth, 2, "mm")} change=${(value) => set(place, value, dragged.turns[place])}/>
    ${cut.may_turn ? html`<${Slider} words=${t("Turn about the axis")} label=${`${t("Turn cut {number} about the axis", { number: cut.number })} [°]`} min=${-TURN} max=${TURN} step=${TURN_STEP} value=${turn} says=${`${shown(turn, 1)}°`} change=${(value) => set(place, dragged.depths[place], value)}/>` : ""}</fieldset>`;
}

const Slider = ({ words, label, min, max, step, value, says, change }) => html`<label class="slider"><span>${words}</span><output>${says}</output><input type="range" min=${min} max=${max} step=${step} value=${value} aria-label=${label} onInput=${({ target }) => change(Number(target.value))}/></label>`;
