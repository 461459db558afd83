// What other depths and angles of the cuts would leave: predicted by the server as one drags, then cut and measured.
import { $, el, measured, predicted, shown, withUnit } from "/static/tools.js";
import { unitOf } from "/static/units.js";
import { t } from "/static/words.js";
import { askJson, askLeft, guarded, post, say } from "/static/server.js";
import { applied, on, state } from "/static/job.js";
import { balance } from "/static/correct.js";
import * as handles from "/static/handles.js";
import { kinds } from "/static/limits.js";
import { start, watched } from "/static/runs.js";

const TURN = 60; // degrees, each way
const TURN_STEP = 0.5; // degrees
let model = null;
let run = null;
let depths = [];
let turns = [];
let sliders = []; // of each cut: { depth, turn }, as functions that set what they show

export function setUp(view) {
  handles.setUp(view);
  $("take-depths").addEventListener("click", () => { applied(asLimits()); balance(); });
  for (const id of ["try-depths", "try-dragged"]) $(id).addEventListener("click", guarded(trial));
  for (const id of ["undo-depths", "undo-dragged"]) $(id).addEventListener("click", asItWas);
  $("undo").addEventListener("click", () => step(undone, redone));
  $("redo").addEventListener("click", () => step(redone, undone));
  document.addEventListener("keydown", (event) => {
    if (!(event.ctrlKey || event.metaKey) || $("panel-see").hidden || /^(INPUT|TEXTAREA|SELECT)$/.test(event.target.tagName) && event.target.type !== "range") return;
    const way = { z: event.shiftKey ? "redo" : "undo", Z: "redo", y: "redo" }[event.key];
    if (!way) return;
    $(way).click();
    event.preventDefault();
  });
  on("units", () => { if (model?.cuts?.length) { for (const all of sliders) all.forEach((each) => each()); predict(); } });
}

// --- undo and redo: every drag, step by step ----------------------------------------------------------------

const undone = [], redone = [];
const TOGETHER_MS = 600; // moves of one cut that follow faster are one step
let last = { place: -1, at: 0 };
function remembered(place) {
  const now = performance.now();
  if (place !== last.place || now - last.at > TOGETHER_MS) { undone.push([[...depths], [...turns]]); redone.length = 0; }
  last = { place, at: now };
  buttons();
}
function step(from, to) {
  if (!from.length) return;
  to.push([[...depths], [...turns]]);
  [depths, turns] = from.pop();
  last = { place: -1, at: 0 };
  everywhere();
}
function everywhere() {
  for (const all of sliders) all.forEach((each) => each());
  $("tried").hidden = true;
  handles.told();
  buttons();
  predict();
}
function buttons() {
  $("undo").disabled = !undone.length;
  $("redo").disabled = !redone.length;
}

export function clear() {
  model = null;
  handles.show([], { cuts: [] });
  for (const id of ["drag-box", "dragged", "tried"]) $(id).hidden = true;
}

export async function show(told) {
  run = told.id;
  model = await askLeft(`/api/runs/${run}/model`);
  $("drag-box").hidden = !model?.cuts?.length;
  if ($("drag-box").hidden) { const left = model; clear(); return left; }
  depths = model.cuts.map((cut) => cut.depth_mm);
  turns = model.cuts.map(() => 0);
  undone.length = redone.length = 0;
  buttons();
  sliders = [];
  $("drags").replaceChildren(...model.cuts.map(fields));
  for (const id of ["try-depths", "try-dragged"]) $(id).hidden = told.verb !== "balance";
  await predict();
  return model;
}

// The view has the result too: handles may stand on it.
export function grips() {
  if (model?.cuts?.length) handles.show(model.cuts, { cuts: model.cuts, at: (place) => ({ depth: depths[place], turn: turns[place] }), set });
}

function set(place, depth, turn) {
  remembered(place);
  const cut = model.cuts[place], step = cut.depth_step_mm;
  const stepped = step ? step * Math.round(depth / step) : depth;
  depths[place] = Math.min(Math.max(stepped, 0), handles.most(cut));
  turns[place] = cut.may_turn ? Math.min(Math.max(Math.round(turn / TURN_STEP) * TURN_STEP, -TURN), TURN) : 0; // whole steps: what a dividing head can set
  sliders[place].forEach((each) => each());
  $("tried").hidden = true;
  handles.told();
  predict();
}

function asItWas() {
  remembered(-2);
  model.cuts.forEach((cut, place) => { depths[place] = cut.depth_mm; turns[place] = 0; });
  everywhere();
}

// --- the same by sliders ----------------------------------------------------------------------------------

function fields(cut, place) {
  const made = el("fieldset", { className: "drag" }, el("legend", { textContent: `${cut.number}. ${cut.label}` }));
  const top = handles.most(cut);
  sliders[place] = [];
  made.append(slider(place, `Depth of cut ${cut.number} [mm]`, 0, top, cut.depth_step_mm || top / 400, 2, () => depths[place], (value) => set(place, value, turns[place])));
  if (cut.may_turn) made.append(slider(place, `Turn cut ${cut.number} about the axis [°]`, -TURN, TURN, 0.5, 1, () => turns[place], (value) => set(place, depths[place], value)));
  return made;
}

function slider(place, words, min, max, step, digits, now, change) {
  const input = el("input", { type: "range", min, max, step, "aria-label": words }), output = el("output");
  let own = false; // what is typed at a slider stands where it was put
  const tell = () => { if (!own) input.value = now(); output.textContent = words.startsWith("Depth") ? withUnit(now(), digits, "mm") : `${shown(now(), digits)}°`; };
  input.addEventListener("input", () => { own = true; change(Number(input.value)); own = false; });
  sliders[place].push(tell);
  tell();
  return el("label", { className: "slider" }, el("span", { textContent: words.replace(/ of cut \d+| cut \d+/, "").replace(/ \[.*\]$/, "") }), output, input);
}

// --- predicted, then measured -----------------------------------------------------------------------------

const FACTS = (found) => [["Residual", "residual.magnitude_g_mm", found.magnitude_g_mm, "g·mm", 3], ...found.planes.map((plane, k) => [`Plane ${plane.name}`, `residual.planes.${k}.magnitude_g_mm`, plane.magnitude_g_mm, "g·mm", 3]), ["Of permitted", "worst_share", found.worst_share, "%", 1], ["Mass", "mass_change_g", found.mass_change_g, "g", 2], ["Inertia", "inertia_change_kg_mm2", found.inertia_change_kg_mm2, "kg·mm²", 3]];
function facts(found, value) {
  return [...FACTS(found).flatMap(([name, key, amount, unit, digits]) => [el("dt", { textContent: t(name) }), el("dd", {}, value(key, amount, digits, unit), ` ${unitOf(unit)}`)]), ...moved()];
}
// Where the cuts that were dragged are now: angle, depth, each with what it was.
function moved() {
  return model.cuts.flatMap((cut, place) => {
    if (depths[place] === cut.depth_mm && !turns[place]) return [];
    const angle = (((state.result?.report.corrections[place]?.angle_deg ?? 0) + turns[place]) % 360 + 360) % 360;
    return [el("dt", { textContent: t("Cut {number}", { number: cut.number }) }), el("dd", { textContent: `${shown(angle, 1)}°, ${withUnit(depths[place], 2, "mm")} ${t("deep")}` })];
  });
}
const percent = (made, key, amount) => { if (key === "worst_share") made.textContent = shown(100 * amount, 1); return made; };
const asPredicted = (key, amount, digits, unit) => percent(predicted(amount, digits, key === "worst_share" ? "" : unit), key, amount);
const asMeasured = (key, amount, digits) => percent(measured(`trial.${key}`, amount, digits), key, amount);

// One question at a time; the latest that was dragged is asked next. What is shown is busy until it is of that.
const SAID = ["predictions", "dragged-says"];
let busy = false;
let again = false;
async function predict() {
  for (const id of SAID) $(id).setAttribute("aria-busy", "true");
  if (busy) { again = true; return; }
  busy = true;
  try {
    const found = await post(`/api/runs/${run}/predict`, { depths_mm: depths, turns_deg: turns });
    for (const id of SAID) {
      $(id).replaceChildren(...facts(found, asPredicted));
      $(id).dataset.within = String(found.worst_share <= 1);
    }
    $("dragged").hidden = !model || model.cuts.every((cut, place) => depths[place] === cut.depth_mm && !turns[place]);
  } catch (error) { say(error.message); }
  busy = false;
  if (again) { again = false; predict(); return; }
  for (const id of SAID) $(id).removeAttribute("aria-busy");
}

// Make the cuts where they were dragged to, and measure the solid's file.
async function trial() {
  const told = await watched(() => start("cut", { run, depths_mm: depths, turns_deg: turns }, "as dragged"));
  if (!told) return;
  const found = (await askJson(`/api/runs/${told.id}/report`)).trial, name = told.files.find((each) => each.startsWith("tried."));
  $("tried-says").replaceChildren(...facts({ ...found, magnitude_g_mm: found.residual.magnitude_g_mm, planes: found.residual.planes }, asMeasured));
  $("tried-says").dataset.within = String(found.within_tolerance);
  Object.assign($("tried-solid"), { hidden: !name, href: `/api/runs/${told.id}/files/${encodeURIComponent(name || "")}`, download: name || "" });
  $("tried").hidden = false;
  $("drag-box").open = true;
  $("tried").scrollIntoView({ block: "nearest" });
}

// The depths and angles that were dragged to, as limits of the job: what the planner then keeps to.
function asLimits() {
  const changes = {};
  for (const name of new Set(model.cuts.map((cut) => cut.kind))) {
    const mine = model.cuts.flatMap((cut, place) => (cut.kind === name ? [place] : []));
    const keys = kinds.of(name).keys.map((each) => each.key);
    if (keys.includes("max_depth_mm") && mine.some((k) => depths[k] !== model.cuts[k].depth_mm)) changes[`correction.${name}.max_depth_mm`] = Math.max(...mine.map((k) => depths[k]));
    if (keys.includes("sectors_deg") && mine.some((k) => turns[k])) changes[`correction.${name}.sectors_deg`] = mine.map((k) => around(state.result.report.corrections[k].angle_deg + turns[k]));
  }
  return changes;
}
const wrapped = (angle) => Math.round(1e3 * (((angle % 360) + 360) % 360)) / 1e3;
const around = (angle) => [wrapped(angle - 1), wrapped(angle + 1)];
