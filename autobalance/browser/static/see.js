// See: the verdict and its numbers as measured, before and after, what was cut, doubts, files.
import { html } from "/static/preact.min.js";
import { $, withUnit } from "/static/tools.js";
import { askBuffer, askJson, guarded } from "/static/server.js";
import { applied, emit, on, state } from "/static/job.js";
import { balance } from "/static/correct.js";
import { Doubts, Numbers } from "/static/result.js";
import { outOf } from "/static/cuts.js";
import * as drag from "/static/drag.js";
import { Panel as Drag } from "/static/drag-panels.js";
import { mount, redraw, signal } from "/static/store.js";
import { t } from "/static/words.js";

const OUTCOMES = { within_tolerance: "Within tolerance", already_within_tolerance: "Already within tolerance", above_tolerance: "Above tolerance" };
const FILES = { "report.html": "Report as a page", "sheet.pdf": "Shop sheet", "balance.xlsx": "Workbook", "crank-before.png": "Picture before", "crank-after.png": "Picture after", "history.html": "History of stages", "reading.toml": "Reading to fill in", "certificate.pdf": "Certificate", "bob-weights.pdf": "Bob-weight card", "holes.csv": "List of holes", "drawing.dxf": "Drawing (DXF)" };
const AXES = { none: "none", z: "the axis", x: "the throw", y: "y" };
let view = null;
const none = signal("No result yet"); // what stands where no result is
const look = { fade: 100, axis: "none", at: 50, place: null }; // how the view shows the result

export function setUp(model) {
  view = model;
  mount(See, $("panel-see"));
  on("look", (out) => view.turnTo(out));
  on("show", (told) => guarded(show)(told));
  on("begun", () => clear("Working …"));
  for (const name of ["forgotten", "gone"]) on(name, () => clear("No result yet"));
}

function clear(words) {
  state.result = null;
  none.value = words;
  drag.clear();
  redraw();
}

export async function show(told) {
  const report = await askJson(`/api/runs/${told.id}/report`);
  clear("");
  const [left] = await Promise.all([drag.show(told), model(told.id)]);
  state.result = { id: told.id, report, told, papers: left?.papers || [] };
  drag.grips();
  if (report.corrections.length) view.turnTo(middle(report.corrections.map(outOf)), [0.15, 0.45, 0.7]);
  emit("result", state.result);
}

// Where most cuts are entered from; that of the first where they stand against each other.
function middle(ways) {
  const unit = (way) => way.map((each) => each / (Math.hypot(...way) || 1));
  const sum = ways.map(unit).reduce((all, way) => all.map((each, axis) => each + way[axis]));
  return Math.hypot(...sum) > 0.3 * ways.length ? sum : ways[0];
}

async function model(id) {
  const buffer = await askBuffer(`/api/runs/${id}/view`);
  if (!buffer) return; // a result from elsewhere has no view
  view.showResult(buffer);
  view.fade(1 - look.fade / 100);
}

function save(name, text) {
  const url = URL.createObjectURL(new Blob([text], { type: "application/toml" }));
  Object.assign(document.createElement("a"), { href: url, download: name }).click();
  setTimeout(() => URL.revokeObjectURL(url), 1000);
}

// --- the panel ------------------------------------------------------------------------------------------------

function See() {
  return html`<${Verdict}/><${Remedies}/><${Files}/><${Look}/><div id="result-numbers"><${Numbers}/></div><${Drag}/><div id="result-doubts"><${Doubts}/></div>`;
}

function Verdict() {
  const report = state.result?.report;
  if (!report) return html`<p role="status" data-testid="verdict" id="verdict" data-outcome="">${t(none.value)}</p><p data-testid="reason" id="reason"></p>`;
  const { told } = state.result;
  const unproven = report.outcome !== "above_tolerance" && report.proven === false;
  return html`<p role="status" data-testid="verdict" id="verdict" data-outcome=${report.outcome} data-proven=${unproven ? "false" : "true"} title=${unproven ? t("Residual and uncertainty together exceed the permissible unbalance.") : ""}>${t(OUTCOMES[report.outcome])}${unproven ? t(", not proven") : ""}</p><p data-testid="reason" id="reason">${report.reason || ""}</p>${told?.crank ? html`<p class="quiet" id="result-of">${told.crank}, ${new Date(told.started).toLocaleString()}</p>` : ""}${told?.job_changed ? html`<p id="job-changed" data-testid="job-changed" role="status">${t("The job has changed since: balance again.")} ${told.changes.slice(0, 3).map(({ key }) => key).join(", ")}</p>` : ""}`;
}

// What would suffice where the limits do not: each change is a button.
function Remedies() {
  const found = (state.result?.report.relaxations || []).filter(({ changes }) => changes.length);
  const values = (changes) => Object.fromEntries(changes.map(({ key, proposed }) => [key, proposed]));
  return html`<div id="relaxations" data-testid="relaxations" class="buttons">${found.map(({ text, changes }) => html`<button type="button" data-changes=${JSON.stringify(values(changes))} onClick=${() => { applied(values(changes)); balance(); }}>${t("Try {change}", { change: text })}</button>`)}</div>`;
}

function Files() {
  const { id, report, told, papers = [] } = state.result || {}, solid = report?.outputs.solid?.file;
  const link = (name, words, more = {}) => html`<a href=${`/api/runs/${id}/${more.room || "files"}/${encodeURIComponent(name)}`} download=${name} id=${more.id} data-testid=${more.id}>${t(words)}</a> `;
  const others = (told?.files || []).filter((name) => name !== "report.json" && name !== solid);
  return html`<p id="downloads">${solid ? link(solid, "Corrected solid", { id: "download-solid" }) : ""}${report ? link("report.json", "Report", { id: "download-report" }) : ""}<span id="more-files">${others.map((name) => link(name, FILES[name] || name))}${papers.map((name) => link(name, FILES[name] || name, { room: "papers" }))}</span> <button type="button" id="download-job" onClick=${() => save("job.toml", state.text)}>${t("Job")}</button></p>`;
}

// Before to after, and a section.
function Look() {
  const share = look.fade / 100;
  const fade = ({ target }) => { look.fade = Number(target.value); view.fade(1 - look.fade / 100); redraw(); };
  const section = (key) => ({ target }) => { look[key] = key === "at" ? Number(target.value) : target.value; look.place = view.section(look.axis, look.at / 100); redraw(); };
  return html`<div class="fields view-fields"><label class="slider"><span>${t("Before to after")}</span><input type="range" id="fade" data-testid="fade" min="0" max="100" value=${look.fade} aria-valuetext=${share === 0 ? t("before") : share === 1 ? t("after") : `${look.fade} % ${t("after")}`} onInput=${fade}/></label>
    <label>${t("Section across")} <select id="section" data-testid="section" value=${look.axis} onInput=${section("axis")}>${Object.entries(AXES).map(([value, words]) => html`<option value=${value}>${t(words)}</option>`)}</select></label>
    <label class="slider"><span>${t("at")} <output id="section-says">${look.place === null ? "" : `${look.axis} = ${withUnit(look.place, 1, "mm")}`}</output></span><input type="range" id="section-at" data-testid="section-at" aria-label=${t("Place of the section")} min="0" max="100" value=${look.at} disabled=${look.axis === "none"} onInput=${section("at")}/></label></div>`;
}
