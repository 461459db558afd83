// The frame about every step: the crank's name, the steps with their states, the state line with its one main button, the polars.
import { html } from "/static/preact.min.js";
import { $, shown, withUnit } from "/static/tools.js";
import { at, crankName, emit, isUnitAsked, state, unitOfFile } from "/static/job.js";
import { line as analyse } from "/static/analyse.js";
import { balance } from "/static/correct.js";
import { unsuited } from "/static/drawing.js";
import { listed, methods } from "/static/limits.js";
import { Heavy, big, missing, read, recut, refused } from "/static/machine.js";
import { coming } from "/static/files.js";
import { kindWords, plannedSays } from "/static/kind-cards.js";
import { doubts, isRefused, reading } from "/static/open.js";
import { preview } from "/static/parts.js";
import { anyMoved, asItWas, dragged, trial } from "/static/drag.js";
import { draggedPolars, previewPolars, resultPolars } from "/static/polar.js";
import { isStart } from "/static/start.js";
import { Cancel, cutting, doing, results, running } from "/static/runs.js";
import { isComparing } from "/static/board.js";
import { remedies } from "/static/see.js";
import { mount } from "/static/store.js";
import { unitOf } from "/static/units.js";
import { deciding, judged } from "/static/verdict.js";
import { angleText, sign } from "/static/zero.js";
import { plain, t } from "/static/words.js";

const tab = () => document.body.dataset.tab;
const to = (name) => () => emit("tab", name);

export function setUp() {
  mount(() => (state.file ? crankName(state.file) : "autobalance"), $("crank-name"));
  STEPS.forEach(([name, words, told], place) => mount(() => html`<${Step} name=${name} words=${words} number=${place + 1} ...${told()}/>`, $(`tab-${name}`)));
  mount(Line, $("line"));
  mount(Strip, $("strip"));
  mount(Key, $("key"));
}

// --- the steps ------------------------------------------------------------------------------------------------

const ICONS = { analyse: "∿", history: "◷" };
const SIGNS = { done: "✓", ask: "?", bad: "✕", stale: "◷" };
function Step({ name, words, number, is = "", says = "" }) {
  const box = $(`tab-${name}`);
  box.dataset.is = is;
  box.setAttribute("aria-label", says ? `${t(words)}: ${says}` : t(words));
  return html`<i aria-hidden="true">${(box.getAttribute("aria-selected") !== "true" && SIGNS[is]) || ICONS[name] || number}</i><b>${t(words)}</b><small>${says}</small>`;
}

function crank() {
  const found = state.inspected?.report.crank;
  if (!found) return {};
  if (isUnitAsked()) return { is: "ask", says: t("1 question") };
  if (doubts.value.length) return { is: "ask", says: t("to look at: {count}", { count: doubts.value.length }) };
  return { is: "done", says: t("throws: {throws}, webs: {webs}", { throws: found.throws.length, webs: found.webs.length }) };
}
function engine() {
  const { found, why } = preview.value;
  if (found) return { is: "done", says: typeof found.balance_factor.initial === "number" ? `${shown(found.balance_factor.initial, 3)} → ${plain(Number(found.balance_factor.target.toFixed(3)))}` : t("factor {factor}", { factor: shown(found.balance_factor.target, 2) }) };
  return why ? { is: "ask", says: t("weights") } : {};
}
const plan = () => (state.inspected ? { is: state.result ? "done" : "", says: listed.cuts ? t("listed cuts") : methods().map(kindWords).join(" + ") } : {});
const TONES = { good: "done", warn: "ask", bad: "bad", stale: "stale" }, SHORT = { good: "within", warn: "not proven", bad: "above", stale: "earlier" };
function result() {
  const found = judged();
  return found ? { is: TONES[found.tone], says: t(SHORT[found.tone]) } : {};
}
function machine() {
  const stages = state.result?.report.stages?.length || 0;
  return state.result ? { is: stages ? "done" : "", says: stages ? t("stage {number}", { number: stages }) : t("not read") } : {};
}
const STEPS = [["open", "Crank", crank], ["parts", "Engine", engine], ["correct", "Plan", plan], ["see", "Result", result], ["machine", "Machine", machine], ["analyse", "Analyses", () => ({})], ["history", "History", () => ({})]];

// --- the state line ------------------------------------------------------------------------------------------------

const NEXT = "→";
// What each step says at its foot: tone, words, a sentence, bars, and the one thing to do next.
const LINES = {
  open: () => {
    const found = state.inspected?.report.crank, file = coming.value || reading.value;
    if (file) return { tone: "work", words: t("Reading {file}", { file }), says: t("Its shape is measured, and what is what in it found out.") };
    if (!found && isRefused.value) return { tone: "bad", words: t("No crank recognised in {file}", { file: state.file }), says: t("Above the list is said why, and what to do."), main: { words: t("Choose a file"), work: () => $("file-input").click() } };
    if (!found) return { tone: "plain", words: t("No crank yet"), says: t("Open a file, take an example or draw a crank."), main: { words: t("Choose a file"), work: () => $("file-input").click() } };
    const isAsking = isUnitAsked() || doubts.value.length > 0;
    return { tone: isAsking ? "warn" : "good", words: isUnitAsked() ? t("Is the file in {unit}?", { unit: t(unitOfFile()) }) : isAsking ? t("Recognised; to look at: {count}", { count: doubts.value.length }) : t("Recognised"), says: t("Throws: {throws}, webs: {webs}, {mass} in the file.", { throws: found.throws.length, webs: found.webs.length, mass: withUnit(found.mass_g, 1, "g") }), main: { words: `${t("To the engine")} ${NEXT}`, work: to("parts") } };
  },
  parts: () => {
    const { found, why } = preview.value, main = { words: `${t("Plan the cuts")} ${NEXT}`, work: to("correct") };
    if (!found) return { tone: "plain", words: t("Weights, factor and speed"), says: why, main };
    const { initial, tolerance, balance_factor: factor, bob_weights: bobs } = found, isWithin = initial.magnitude_g_mm <= tolerance.permissible_g_mm && initial.planes.every((plane, k) => plane.magnitude_g_mm <= tolerance.planes[k].permissible_g_mm);
    const { initial: now, target } = factor, bob = bobs[0], isMany = new Set(bobs.map((each) => each.mass_g)).size > 1;
    const words = isWithin ? t("Within tolerance as it is") : typeof now === "number" && now !== target ? t(now > target ? "Counterweights too heavy" : "Counterweights too light") : t("Above tolerance as it is");
    const [place, most, limit] = deciding(initial, tolerance);
    const says = [typeof now === "number" ? t("Factor {now} today, {wanted} wanted.", { now: shown(now, 3), wanted: shown(target, 3) }) : t("Factor {wanted} wanted.", { wanted: shown(target, 3) }), bob ? `${t("Bob-weight {mass}.", { mass: withUnit(bob.mass_g, 2, "g") })} ${Math.abs(bob.fit_g - bob.mass_g) > 5e-3 ? t("Clamp on {mass}.", { mass: withUnit(bob.fit_g, 2, "g") }) : ""}${isMany ? t("One for each throw.") : ""}` : "", most.magnitude_g_mm > 0 && !isWithin ? t("Heavy side at {angle}.", { angle: `${angleText((Math.atan2(most.unbalance_g_mm[1], most.unbalance_g_mm[0]) * 180) / Math.PI)} ${sign()}` }) : ""].join(" ");
    const drawn = isWithin ? null : unsuited();
    return { tone: isWithin ? "good" : "bad", words, says: drawn ? drawn.says : says, bars: [[place, most.magnitude_g_mm, null, limit]], more: drawn?.more, main };
  },
  correct: () => {
    const run = cutting(), compares = isComparing() && (running().find((each) => each.verb === "compare") || { words: "done", share: 1 });
    if (run || compares) return { tone: "work", words: run ? t("Cutting and measuring") : t("Comparing all kinds of cut"), says: `${doing((run || compares).words)}, ${Math.round(100 * (run || compares).share)} %`, cancel: true };
    const needs = !state.file ? t("Open a crank first.") : isUnitAsked() ? t("Answer 1 question in Crank: the unit of the file.") : "", { found, why } = preview.value;
    if (!needs && !found && why && !listed.cuts) return { tone: "warn", words: t("The engine is not complete"), says: why, more: { id: "to-engine", text: t("To the engine"), work: to("parts") }, main: { id: "balance", words: t("Cut and measure"), work: () => balance() } };
    const planned = needs ? null : plannedSays();
    if (planned) return { tone: "plain", words: planned.words, says: planned.says, bars: preview.value.found ? [[t("Resultant"), planned.left, null, preview.value.found.tolerance.permissible_g_mm]] : [], main: { id: "balance", words: t("Cut and measure"), work: () => balance() } };
    return { tone: "plain", words: listed.cuts ? t("Listed cuts: {count}", { count: listed.cuts.length }) : t("Ready to plan: {method}", { method: methods().map(kindWords).join(" + ") }), says: needs || t("The cuts are planned, made in the solid, and measured on the written file."), main: { id: "balance", words: t("Cut and measure"), off: Boolean(needs), work: () => balance() } };
  },
  see: () => {
    const found = judged(), run = cutting();
    if (run) return { tone: "work", words: t("Cutting and measuring"), says: `${doing(run.words)}, ${Math.round(100 * run.share)} %`, cancel: true };
    if (!found) return { tone: "plain", words: t("No result yet"), says: t("Plan the cuts, then cut and measure."), main: { words: `${t("Plan the cuts")} ${NEXT}`, work: to("correct") } };
    const isStale = found.tone === "stale", isMoved = anyMoved() && dragged.left;
    if (isMoved) return { tone: dragged.left.worst_share <= 1 ? "warn" : "bad", words: t("Moved by hand, not cut yet"), says: t("Predicted: {left} of what is permitted.", { left: `${shown(100 * dragged.left.worst_share, 0)} %` }), bars: predictedBars(), main: dragged.verb === "balance" ? { id: "line-cut-moved", words: t("Cut and measure"), work: trial } : { id: "line-as-it-was", words: t("Reset"), work: asItWas } };
    if (!isStale && found.tone === "bad") return { ...found, bars: worstBar(), ...helps(found) };
    return { ...found, says: isStale ? t("The job has changed since then.") : found.says, bars: planeBars(), main: isStale ? { id: "line-cut-again", words: t("Cut again"), work: () => balance() } : { words: `${t("To the machine")} ${NEXT}`, work: to("machine") } };
  },
  machine: () => {
    if (!state.result) return { tone: "plain", words: t("No result yet"), says: t("Balance a crank first; then spin it and enter what the machine reads."), main: { words: `${t("Plan the cuts")} ${NEXT}`, work: to("correct") } };
    const run = cutting(), needs = Object.values(missing())[0], { report } = state.result, planes = report.tolerance.planes;
    if (run) return { tone: "work", words: t("Cutting and measuring"), says: `${doing(run.words)}, ${Math.round(100 * run.share)} %`, cancel: true };
    const bars = (read.planes === "2" ? [1, 2] : [1]).map((place) => [t("{plane} read", { plane: read[`at-${place}`] || place }), read[`g-mm-${place}`], null, (planes[place - 1] || state.result.report.tolerance).permissible_g_mm]).filter(([, value]) => typeof value === "number");
    const isWithin = bars.every(([, value, , limit]) => value <= limit);
    const next = needs && !bars.length && report.command === "recut" && (report.corrections.length || report.outcome !== "above_tolerance") ? { count: report.corrections.length } : null;
    const more = { text: t("Big digits"), id: "big", work: () => { big.value = true; } };
    if (refused.value && !needs) return { tone: "warn", words: t("The reading is in doubt"), says: t("Check what was typed; if it is right, continue with it."), bars, more: { text: t("The reading is right: continue"), id: "line-trust", work: () => recut(true) }, main: { id: "recut", words: t("Plan the next cuts"), work: () => recut(false) } };
    return { tone: next?.count === 0 ? "good" : needs ? "plain" : isWithin ? "good" : "bad", words: next ? (next.count ? t("Next cuts: {count}", next) : t("Nothing more to cut")) : needs ? t("Nothing read yet") : t(isWithin ? "Read within tolerance" : "Read above tolerance"), says: next?.count === 0 ? t("The crank is within tolerance as it was read; its certificate is among the documents of the result.") : next ? t("Make them, spin the crank again and enter what the machine reads then.") : needs || t("The next cuts follow from the reading."), bars, more, main: next?.count === 0 ? { words: `${t("To the result")} ${NEXT}`, work: to("see") } : { id: "recut", words: t("Plan the next cuts"), off: Boolean(needs), work: () => recut(false) } };
  },
  analyse,
  history: () => ({ tone: "plain", words: t("History"), says: t("Results: {count}", { count: results().length }), main: { words: `${t(state.result ? "To the result" : "To the crank")} ${NEXT}`, work: to(state.result ? "see" : "open") } }),
};
// Above tolerance the main button is what helps: other counterweights, a change that suffices, else another plan. Of a reading the machine's step plans on.
function helps({ says }) {
  const plan = { id: "line-change-plan", text: t("Change the plan"), work: to("correct") }, drawn = unsuited(), [remedy] = remedies();
  if (state.result.report.command === "recut") return { more: plan, main: { words: `${t("To the machine")} ${NEXT}`, work: to("machine") } };
  if (drawn) return { says: drawn.says, more: plan, main: { ...drawn.more, words: drawn.more.text } };
  if (remedy) return { says: `${says} ${t("What would do it: {change}.", { change: remedy.words })}`, more: plan, main: { id: "line-remedy", words: t("Try the change"), work: remedy.work } };
  return { main: { id: "line-change-plan", words: `${plan.text} ${NEXT}`, work: plan.work } };
}
// The place that decides, alone: two buttons and what helps need the room.
const worstBar = () => {
  const { residual, tolerance } = state.result.report, [place, most, limit] = deciding(residual, tolerance);
  return [[place, most.magnitude_g_mm, most.uncertainty_g_mm, limit]];
};
const predictedBars = () => {
  const { tolerance } = state.result.report, { planes, magnitude_g_mm: size } = dragged.left;
  return planes.length ? planes.map((plane, k) => [`${t("Plane")} ${plane.name}`, plane.magnitude_g_mm, null, tolerance.planes[k].permissible_g_mm, true]) : [[t("Resultant"), size, null, tolerance.permissible_g_mm, true]];
};
const planeBars = () => {
  const { residual, tolerance } = state.result.report, planes = residual.planes.map((plane, k) => [`${t("Plane")} ${plane.name}`, plane.magnitude_g_mm, plane.uncertainty_g_mm, tolerance.planes[k].permissible_g_mm]);
  return planes.length ? planes : [[t("Resultant"), residual.magnitude_g_mm, residual.uncertainty_g_mm, tolerance.permissible_g_mm]];
};

function Line() {
  document.body.dataset.first = String(isStart());
  const { tone, words, says, bars = [], main, more, cancel } = LINES[tab()]();
  const box = $("line");
  box.dataset.tone = tone;
  return html`<div class="what" role="status" data-testid="state-line" data-tone=${tone}><b>${words}</b><span>${says}</span></div><div class="bars">${bars.map((each) => html`<${Bar} of=${each}/>`)}</div>
    <div class="go">${more ? html`<button type="button" data-testid=${more.id} disabled=${Boolean(more.off)} onClick=${more.work}>${more.text}</button>` : ""}${cancel ? html`<${Cancel} id="line-cancel"/>` : ""}${main ? html`<button type="button" class="main" key=${main.id || tab()} id=${main.id || "next"} data-testid=${main.id || "next"} disabled=${Boolean(main.off)} onClick=${main.work}>${main.words}</button>` : ""}</div>`;
}

// Zero at the left, the permitted at the tick; hatched: the uncertainty.
const TICK = 75;
function Bar({ of: [name, value, off, limit, isPredicted] }) {
  const share = (each) => `${Math.min(100, (TICK * each) / limit).toFixed(1)}%`;
  return html`<div class="bar"><b>${name}</b><span><strong class=${isPredicted ? "predicted" : ""}>${shown(value, 2, "g·mm")}</strong> ${t("of {limit}", { limit: `${shown(limit, 2, "g·mm")} ${unitOf("g·mm")}` })}</span><i aria-hidden="true"><u style=${{ width: share(value) }}></u>${off ? html`<em style=${{ width: share(value + off) }}></em>` : ""}</i></div>`;
}

// --- below and over the model -----------------------------------------------------------------------------------------

function Strip() {
  const { found } = preview.value, report = state.result?.report, contents = (id, parts) => html`<div class="contents" id=${id}>${parts}</div>`;
  if (tab() === "machine" && report) return contents("read-polars", (read.planes === "2" ? [1, 2] : [1]).map((place) => html`<${Heavy} place=${place}/>`));
  if (["see", "machine"].includes(tab())) return report ? contents("polars", tab() === "see" && anyMoved() && dragged.left ? draggedPolars(report, dragged.left) : resultPolars(report)) : "";
  return found ? contents("preview-polar", previewPolars(found)) : "";
}

const PARTS = [["journal", "main journals"], ["pin", "crankpins"], ["web", "webs"], ["weight", "counterweights"]];
// Metal that is added, or a slug that is heavier than its bore, has a mass below zero among what comes off.
const changedKey = (corrections) => {
  const added = corrections.filter((each) => each.removed_mass_g < 0).length;
  return [["cut", !added ? "removed metal" : added === corrections.length ? "added metal" : "removed or added metal"]];
};
// A crank that is pressed up without its pin shows none.
const partsSeen = () => PARTS.filter(([colour]) => colour !== "pin" || at("crankshaft.crankpin_in_file") !== false);
const isOfResult = () => ["see", "machine"].includes(tab()) && state.result;
const Key = () => (state.inspected || state.result ? (isOfResult() ? [...changedKey(state.result.report.corrections), ...partsSeen()] : partsSeen()).map(([colour, words]) => html`<span><i class="swatch" style=${{ "--c": `var(--${colour})` }}></i>${t(words)}</span>`) : "");
