// Open: the crank that is looked at, what was recognised in it and what is in doubt, and what a user says of it.
import { html } from "/static/preact.min.js";
import { $, ending, shown, typed, withUnit } from "/static/tools.js";
import { askBuffer, askJson, askLeft, behind, guarded, put, say } from "/static/server.js";
import { UNITLESS, assumed, at, changed, crankName, crankshaft, emit, isUnitAsked, keep, ofFile, on, state, unitOfFile } from "/static/job.js";
import { JobField } from "/static/fields.js";
import { Drawn, setUp as drawsWith } from "/static/drawing.js";
import { coming, sending, setUp as takeFiles } from "/static/files.js";
import { Measured } from "/static/measured.js";
import { start } from "/static/runs.js";
import { mount, redraw, redrawNow, signal } from "/static/store.js";
import { Start, Ways, isStart } from "/static/start.js";
import { Tree } from "/static/tree.js";
import { said } from "/static/said.js";
import { plain, t } from "/static/words.js";

let view = null;
let opening = 0, newest = 0; // newest: the last that was begun
export const reading = signal(""); // the file that is being measured
export const isRefused = signal(false); // whether the file was read last without a crank in it
export const doubts = signal([]); // what is in doubt, as texts or elements
export const chosen = signal({ row: "", part: 0 }); // the row of the tree, and the part of the model from 1, that was chosen

export function setUp(model) {
  view = model;
  takeFiles(open);
  drawsWith(open);
  mount(Open, $("panel-open"));
  on("forgotten", () => { $("panels").scrollTop = 0; if ($("other-crank")) $("other-crank").open = false; opening++; view.clear(); isRefused.value = false; doubts.value = []; chosen.value = { row: "", part: 0 }; });
}

// --- the crank is looked at ---------------------------------------------------------------------------------

let going = null; // what is being opened: asked twice, it is opened once
export function open() {
  const what = JSON.stringify(crankshaft());
  if (going?.what === what) return going.end;
  const mine = { what, end: opens().finally(() => { if (going === mine) going = null; }) };
  going = mine;
  return mine.end;
}
const opens = guarded(async () => {
  if (!state.file) throw new Error(t("choose a crank file first"));
  const mine = newest = ++opening;
  $("model").dataset.state = "loading";
  doubts.value = [];
  reading.value = state.file;
  isRefused.value = false;
  try {
    const told = await inspected();
    if (mine !== opening) return;
    opening++; // what was on its way meanwhile comes too late
    if (told) await show(told.id, true);
    else view.clear();
  } catch (error) {
    if (mine !== opening) return;
    opening++;
    view.clear();
    bodies.value = 0;
    state.inspected = null;
    isRefused.value = true;
    reading.value = "";
    say(error.message);
    if (error.run) await unrecognised(error);
  } finally { if (newest === mine) reading.value = ""; }
});

// A crank of several bodies, or without crankpins, may be a pressed-up one: looked at as such, unless it was said.
async function inspected() {
  const asked = crankshaft();
  const look = (crank) => start("inspect", { job: { crankshaft: crank } }, state.file, meanwhile(opening));
  try { return await look(asked); } catch (error) {
    if (asked.crankpin_in_file !== undefined || !/bodies|crankpin|throw/.test(error.message)) throw error;
    try { return await look({ ...asked, crankpin_in_file: false }); } catch { throw error; }
  }
}

// The solid is shown as soon as it is built, while what is what in it is still being found out.
function meanwhile(mine) {
  let asked = false;
  return async (told) => {
    if (mine !== opening) return;
    if (!asked) view.say(t("Reading …"));
    if (asked || !told.share) return;
    asked = true;
    const mesh = await askBuffer(`/api/runs/${told.id}/mesh`).catch(() => null); // the run tells what went wrong
    if (mesh && mine === opening) view.showCrank(mesh, false);
  };
}

export async function show(id, fresh = false) {
  const mine = opening, report = await askJson(`/api/runs/${id}/report`), model = await askLeft(`/api/runs/${id}/model`), mesh = await askBuffer(`/api/runs/${id}/mesh`);
  if (mine !== opening) return; // another crank is opened meanwhile
  if (fresh && model?.crankpin_in_file === false && at("crankshaft.crankpin_in_file") === undefined) keep("crankshaft.crankpin_in_file", false);
  if (mesh) view.showCrank(mesh);
  state.inspected = { id, report };
  bodies.value = 0;
  chosen.value = { row: "", part: 0 };
  doubts.value = reasons(report);
  if (mesh && (fresh || !state.cranks[state.file]?.picture)) setTimeout(pictured, PICTURED_MS, state.file);
  if (fresh && report.crank.main_journals.length < 2 && !at("balance.tolerance_planes_mm")) keep("balance.judge", "static");
  emit("opened");
  if (fresh) changed();
}

// A small picture of the crank, by which its user finds it again: the middle of the view.
const WIDE_PX = 184, HIGH_PX = 128, PICTURED_MS = 3000; // once the page has what it shows
async function picture() {
  if (!view.renderer || view.mode !== "crank") return null;
  const canvas = Object.assign(document.createElement("canvas"), { width: WIDE_PX, height: HIGH_PX }), { width, height } = view.renderer.domElement, scale = HIGH_PX / Math.min(width, height);
  const others = view.scene.children.filter((each) => each.userData.arrows);
  for (const each of others) each.visible = false;
  view.drawn(); // what was drawn is gone once it was shown
  canvas.getContext("2d").drawImage(view.renderer.domElement, (WIDE_PX - scale * width) / 2, (HIGH_PX - scale * height) / 2, scale * width, scale * height);
  for (const each of others) each.visible = true;
  view.draw();
  return new Promise((resolve) => canvas.toBlob(resolve, "image/png"));
}
const pictured = behind(async (file) => {
  const made = await picture();
  if (file !== state.file) return;
  if (!made) { if (view.renderer) setTimeout(pictured, PICTURED_MS, file); return; } // a result is shown: later
  state.cranks = (await askJson(`/api/cranks/picture?file=${encodeURIComponent(file)}`, { method: "PUT", body: made })).cranks;
  redraw();
});

// A file of several bodies: which of them is the crank is a question, its solid is shown meanwhile.
const bodies = signal(0), MOST_BODIES = 6;
function Bodies() {
  if (!bodies.value) return "";
  const take = (body) => () => { bodies.value = 0; keep("crankshaft.body", body); changed(); say(""); open(); };
  const each = Array.from({ length: Math.min(bodies.value, MOST_BODIES) }, (_, k) => k + 1);
  return html`<div class="tell" data-tone="warn" data-testid="bodies"><h3>${t("The file holds {count} bodies. Which is the crank?", { count: bodies.value })}</h3><p class="buttons">${each.map((number) => html`<button type="button" data-body=${String(number)} onClick=${take(number)}>${t("Body {number}", { number })}</button>`)}<button type="button" data-body="all" onClick=${take("all")}>${t("All of them together")}</button></p></div>`;
}

// No crank was recognised: its solid and the cylinders in it, to say what is what.
async function unrecognised(error) {
  const mesh = await askBuffer(`/api/runs/${error.run}/mesh`);
  if (!mesh) return;
  bodies.value = Number(error.message.match(/holds (\d+) bodies/)?.[1] || 0);
  view.showCrank(mesh);
  doubts.value = [said(error.message), ...(view.parts.length ? [t("pick a cylinder in the model or in the list below, and say what it is")] : [])];
}

function reasons(report) {
  const off = report.crank.journal_misalignment_mm, free = view.parts.filter((part) => part.kind === "cylinder").length;
  return [...strange(report), ...report.warnings.map(said),
    ...(off > 0.01 ? [html`${t("the main journals are out of line by")} <${Measured} of="crank.journal_misalignment_mm" value=${off} digits=${3} named/>`] : []),
    ...(free ? [t("cylinders that are neither main journals nor crankpins: {count}", { count: free })] : [])];
}

// A file without a unit is read in one: a crank of a weight that none has was read in the wrong one.
const LIGHTEST_G = 100, HEAVIEST_G = 500e3;
function strange({ crank }) {
  const mass = crank.mass_g;
  if (!UNITLESS.includes(ending(state.file)) || (mass >= LIGHTEST_G && mass <= HEAVIEST_G)) return [];
  return [html`<span data-testid="unit-strange">${t("In {unit} the crank weighs {mass}. Is that the unit of the file?", { unit: t(unitOfFile()), mass: mass < 1e4 ? withUnit(mass, 1, "g") : `${shown(mass / 1000, 0)} kg` })}</span>`];
}

// --- what a user says of a cylinder ---------------------------------------------------------------------------

// A row of the tree: its part is coloured, or a ring shown where it is.
export function choose({ row, kind, number, centre, radius }) {
  const part = view.parts.findIndex((each) => each.kind === kind && each.number === number) + 1;
  view.mark(part ? [part] : []);
  view.point(part ? null : centre, radius);
  chosen.value = { row, part };
}
export function pickedInModel(hit) {
  const part = hit && hit.part ? view.parts[hit.part - 1] : null;
  choosePart(hit ? hit.part : 0, part ? `${part.kind} ${part.number}` : "");
  redrawNow();
  $("tree").querySelector("[aria-selected=true]")?.scrollIntoView({ block: "nearest" });
}
function choosePart(part, row) {
  view.mark(part ? [part] : []);
  view.point(null);
  chosen.value = { row, part };
}

const hint = (part) => ({ centre_mm: part.file_centre_mm, diameter_mm: part.diameter_mm, width_mm: part.width_mm });
// Take a cylinder for a main journal, a crankpin, or neither.
function override(key) {
  const part = view.parts[chosen.value.part - 1];
  for (const [list, kind] of Object.entries({ main_journals: "main_journal", crankpins: "throw" })) {
    const kept = view.parts.filter((each) => each.kind === kind && each !== part).map(hint);
    if (list === key) keep(`crankshaft.${list}`, [...kept, hint(part)]);
    else if (part.kind === kind) keep(`crankshaft.${list}`, kept.length ? kept : undefined);
  }
  changed();
  open();
}
function forget() {
  for (const key of ["main_journals", "crankpins"]) keep(`crankshaft.${key}`, undefined);
  changed();
  open();
}

// --- the panel ------------------------------------------------------------------------------------------------

const DENSITY = { key: "density_kg_m3", words: "Density", unit: "kg/m³", kind: "number", choices: [], says: "" };
const PINS = { "": "find out", true: "yes", false: "no, pressed up" };

function Open() {
  if (!state.isKnown) return "";
  if (isStart()) return html`<${Start}/>`;
  const pin = at("crankshaft.crankpin_in_file"), setPin = ({ target }) => { keep("crankshaft.crankpin_in_file", target.value === "" ? undefined : target.value === "true"); changed(); };
  return html`<${Name}/><${Unit}/><${Bodies}/><ul id="doubts" aria-label=${t("Warnings")} aria-live="polite">${doubts.value.map((each) => html`<li>${each}</li>`)}</ul><${Cylinder}/>
    <div class="fields"><${JobField} id="density" testid="density" table="crankshaft" label=${t("Density [kg/m³]")} field=${{ ...DENSITY, default: String(assumed.density_kg_m3) }} help=${false}/>
      <label>${t("Crankpin in the file")} <select data-testid="crankpin-in-file" id="crankpin-in-file" value=${pin === undefined ? "" : String(pin)} onInput=${setPin}>${Object.entries(PINS).map(([value, words]) => html`<option value=${value}>${t(words)}</option>`)}</select></label></div>
    <p class="buttons"><button type="button" data-testid="open" id="open" onClick=${async () => { await sending(); open(); }}>${t("Measure it again")}</button> <button type="button" id="forget-overrides" hidden=${!at("crankshaft.main_journals") && !at("crankshaft.crankpins")} onClick=${forget}>${t("Recognise it all again")}</button></p>
    <h2 class="small">${t("Recognised features")}</h2><${Tree} report=${state.inspected?.report} row=${chosen.value.row} choose=${choose}/><${Cylinders}/>
    <details class="fold" id="other-crank"><summary>${t("Another crank")}</summary><${Ways}/></details>`;
}

// What the crank is called: at first as its file; the names of its papers begin with it.
const naming = signal(null); // a name while it is typed: what redraws the panel meanwhile leaves it
const rename = guarded(async ({ target }) => { state.cranks = (await put("/api/cranks", { file: state.file, name: target.value })).cranks; naming.value = null; redraw(); });
const typedName = () => (naming.value?.file === state.file ? naming.value.name : crankName(state.file));
const toAnother = () => { $("other-crank").open = true; $("other-crank").scrollIntoView(); };
function Name() {
  if (!state.file || coming.value) return html`<h2>${coming.value || state.file}</h2>`;
  return html`<label class="named">${t("Name of the crank")} <input id="crank-called" data-testid="crank-called" maxlength="80" value=${typedName()} onInput=${({ target }) => { naming.value = { file: state.file, name: target.value }; }} onChange=${rename}/><small class="quiet">${t("File: {file}", { file: state.file })}</small></label><p class="buttons tight"><button type="button" class="small" data-testid="to-another" onClick=${toAnother}>${t("Another crank")}</button></p><${Scaled} file=${state.file}/><${Drawn}/>`;
}
// Where a crank's solid comes from, if its file was scaled.
export function Scaled({ file }) {
  const { scaled_from: from, factor, stroke_mm: stroke } = state.cranks[file] || {};
  return from ? html`<p class="quiet" data-testid="scaled">${t("Scaled from {file} by {factor}, so that the stroke is {stroke}.", { file: from, factor: plain(Number(factor.toPrecision(6))), stroke: withUnit(stroke, 2, "mm") })}</p>` : "";
}

// The unit of a file that has none: asked until it is answered, and never that of the file before.
const UNITS = ["mm", "cm", "m", "inch"];
const MM_PER = { mm: 1, cm: 10, m: 1000, inch: 25.4 }, CLOSE = 0.01;
const strokeTyped = signal({ text: "", why: "" });
// A stroke that somebody knows says the unit: the one in which the crank has it.
const byStroke = guarded(async (again) => {
  const wanted = typed(strokeTyped.value.text), says = (why) => { strokeTyped.value = { ...strokeTyped.value, why }; };
  if (typeof wanted !== "number" || !(wanted > 0)) { says(t("Enter the stroke in mm, above 0.")); return; }
  const found = await firstThrow();
  if (!found) { says(t("No throw was measured in the file, in any unit.")); return; }
  const inFile = (2 * found.crank_radius_mm) / MM_PER[unitOfFile()], unit = UNITS.find((each) => Math.abs(wanted / (inFile * MM_PER[each]) - 1) < CLOSE);
  if (!unit) { scaled(wanted, wanted / inFile); return; }
  strokeTyped.value = { text: "", why: "" };
  assumed.unit = unit;
  keep("crankshaft.unit", unit);
  changed();
  again();
});
// A crank too small or too large to be measured in the unit that was taken is measured in another: its shape is the same.
async function firstThrow() {
  const own = unitOfFile(), of = () => state.inspected?.report.crank.throws[0];
  for (const unit of [own, ...UNITS.filter((each) => each !== own)]) {
    if (of()) break;
    assumed.unit = unit;
    if (at("crankshaft.unit")) keep("crankshaft.unit", unit);
    await open();
  }
  return of();
}
// A stroke that fits no unit: the solid is scaled to it, as a file of its own in mm; what was said of its cylinders goes with it.
const scaled = guarded(async (stroke, factor) => {
  const told = await start("scale", { job: { crankshaft: { file: state.file } }, factor, stroke_mm: stroke }, state.file);
  if (!told) return;
  const { file } = await askJson(`/api/runs/${told.id}/report`), grown = factor / MM_PER[unitOfFile()];
  state.cranks = (await askJson("/api/cranks")).cranks;
  strokeTyped.value = { text: "", why: "" };
  assumed.unit = "mm";
  const changes = { "crankshaft.unit": "mm" };
  for (const key of ["main_journals", "crankpins"]) {
    const said = at(`crankshaft.${key}`);
    if (said) changes[`crankshaft.${key}`] = said.map((each) => ({ centre_mm: each.centre_mm.map((value) => grown * value), diameter_mm: grown * each.diameter_mm, width_mm: grown * each.width_mm }));
  }
  ofFile(file, changes);
  await open();
});
function Unit() {
  if (!UNITLESS.includes(ending(coming.value || state.file))) return html`<div id="unit-field" hidden></div>`;
  const isAsked = isUnitAsked(), answer = (unit) => { assumed.unit = unit; keep("crankshaft.unit", unit); changed(); };
  const setUnit = ({ target }) => answer(target.value);
  const again = async () => { await sending(); if (state.file) open(); };
  return html`<div id="unit-field" class="tell" data-tone=${isAsked ? "warn" : "plain"} data-testid="unit-question" data-asked=${String(isAsked)}>${isAsked ? html`<h3>${t("Is the file in {unit}?", { unit: t(unitOfFile()) })}</h3><p>${t("The file has no unit.")}${long() === null ? "" : ` ${t("In {unit} the crank is {length} from the first web to the last.", { unit: t(unitOfFile()), length: withUnit(long(), 0, "mm") })}`}</p>` : ""}
    <label>${t("Unit of the file")} <select data-testid="unit" id="unit" value=${unitOfFile()} onInput=${setUnit} onChange=${again}>${UNITS.map((each) => html`<option value=${each}>${t(each)}</option>`)}</select></label>${isAsked ? html` <button type="button" id="unit-yes" data-testid="unit-yes" onClick=${() => answer(unitOfFile())}>${t("Yes, {unit}", { unit: t(unitOfFile()) })}</button>` : ""}${isAsked || isRefused.value || (state.inspected && strange(state.inspected.report).length) ? html`
    <div class="stroke"><label>${t("or: my stroke is [mm]")} <input id="stroke" data-testid="stroke" inputMode="decimal" value=${strokeTyped.value.text} aria-describedby="stroke-note" aria-invalid=${strokeTyped.value.why ? "true" : undefined} onInput=${({ target }) => { strokeTyped.value = { text: target.value, why: "" }; }}/></label> <button type="button" data-testid="by-stroke" onClick=${() => byStroke(again)}>${t("Use my stroke")}</button><small class="note" id="stroke-note">${strokeTyped.value.why}</small></div>` : ""}</div>`;
}

// How long the crank is in the unit that the page took: a wrong one is seen at once.
export function long() {
  const report = state.inspected?.report;
  if (!report || !UNITLESS.includes(ending(state.file))) return null;
  const ends = report.crank.webs.flatMap((web) => [web.z_min_mm, web.z_max_mm]);
  return Math.max(...ends) - Math.min(...ends);
}

function Cylinder() {
  const part = view.parts[chosen.value.part - 1];
  if (!part?.file_centre_mm) return html`<div id="cylinder" hidden></div>`;
  const now = { main_journal: t("is main journal {number}", part), throw: t("is the crankpin of throw {number}", part), cylinder: t("is neither a main journal nor a crankpin") }[part.kind];
  const as = (id, key, words) => html`<button type="button" id=${id} onClick=${() => override(key)}>${t(words)}</button> `;
  return html`<div id="cylinder"><p id="cylinder-says" aria-live="polite">${t("This cylinder, {size}, {now}. It is", { size: sizeOf(part), now })}</p>${as("is-journal", "main_journals", "a main journal")}${as("is-crankpin", "crankpins", "a crankpin")}${as("is-neither", null, "neither")}</div>`;
}
const sizeOf = (part) => `⌀${withUnit(part.diameter_mm, 2, "mm")} × ${withUnit(part.width_mm, 2, "mm")}`;

function Cylinders() {
  const free = view.parts.flatMap((part, k) => (part.kind === "cylinder" ? [[part, k + 1]] : []));
  return html`<details id="cylinders-box" hidden=${!free.length}><summary>${t("Cylinders that are neither main journals nor crankpins")}</summary><ul id="cylinders">${free.map(([part, place]) => html`<li><button type="button" onClick=${() => choosePart(place, "")}>${sizeOf(part)}</button></li>`)}</ul></details>`;
}
