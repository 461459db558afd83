// See: the verdict and its numbers as measured, before and after, what was cut, doubts, files.
import { html } from "/static/preact.min.js";
import { $, withUnit } from "/static/tools.js";
import { askBuffer, askJson, askText, guarded, post } from "/static/server.js";
import { applied, asFileName, brought, changed, crankName, emit, on, state } from "/static/job.js";
import { Listed, balance } from "/static/correct.js";
import { Doubts, Numbers } from "/static/result.js";
import { Cuts, outOf } from "/static/cuts.js";
import * as drag from "/static/drag.js";
import { Panel as Drag } from "/static/drag-panels.js";
import { mount, redraw, signal } from "/static/store.js";
import { open } from "/static/open.js";
import { toast } from "/static/toast.js";
import { changeText, judged } from "/static/verdict.js";
import { said } from "/static/said.js";
import { locale, t } from "/static/words.js";

const FILES = { "report.html": "Report as a page", "sheet.pdf": "Shop sheet", "balance.xlsx": "Workbook", "crank-before.png": "Picture before", "crank-after.png": "Picture after", "history.html": "History of stages", "reading.toml": "Blank reading file", "certificate.pdf": "Certificate", "bob-weights.pdf": "Bob-weight card", "holes.csv": "List of holes", "drawing.dxf": "Drawing (DXF)" };
let view = null;
const none = signal("No result yet"); // what stands where no result is
const look = { fade: 100 }; // how the view shows the result

export function setUp(model) {
  view = model;
  mount(See, $("panel-see"));
  on("look", (out) => view.turnTo(out));
  on("show", guarded(asked));
  on("begun", () => clear("Working …"));
  for (const name of ["forgotten", "gone"]) on(name, () => { showing++; clear("No result yet"); });
}

function clear(words) {
  state.result = null;
  none.value = words;
  drag.clear();
  redraw();
}

// A result belongs to its crank: one of another crank brings that crank with the job that made it.
async function asked(told) {
  if (!isOfThis(told)) {
    await brought(() => post("/api/open", { run: told.id }), true);
    changed();
    await open();
  }
  await show(await askJson(`/api/runs/${told.id}`));
}
export const isOfThis = (told) => !told.crank || told.crank === state.file;

// A run that ended: its result is shown if its crank still is.
export async function ended(told) {
  if (isOfThis(told)) { await show(told); return true; }
  toast(t("The result of {crank} is ready, among the runs.", { crank: crankName(told.crank) }));
  redraw();
  return false;
}

let showing = 0;
export async function show(told) {
  const mine = ++showing, report = await askJson(`/api/runs/${told.id}/report`);
  if (mine !== showing || !isOfThis(told)) return;
  drag.clear();
  none.value = "";
  const [left] = await Promise.all([drag.show(told), model(told.id)]).catch((error) => { clear(""); throw error; });
  if (mine !== showing) return;
  state.result = { id: told.id, report, told, papers: left?.papers || [], radii: left?.radii_mm || [], setups: left?.setups || [] };
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

// The job that made this result, as a file.
const saveJob = guarded(async () => save(savedName(state.result.told, "job.toml"), await askText(`/api/runs/${state.result.id}/job`)));
function save(name, text) {
  const url = URL.createObjectURL(new Blob([text], { type: "application/toml" }));
  Object.assign(document.createElement("a"), { href: url, download: name }).click();
  setTimeout(() => URL.revokeObjectURL(url), 1000);
}

// --- the panel ------------------------------------------------------------------------------------------------

function See() {
  return html`<${Verdict}/><${Remedies}/><${Listed}/><${Cuts} id="cuts" corrections=${state.result?.report.corrections || []}/><${Files}/><${Look}/><div id="result-numbers"><${Numbers}/></div><${Drag}/><div id="result-doubts"><${Doubts}/></div>`;
}

function Verdict() {
  const found = judged(), { report, told } = state.result || {};
  if (!found) return html`<div role="status" data-testid="verdict" id="verdict" data-outcome=""><h2>${t(none.value)}</h2></div><p data-testid="reason" id="reason"></p>`;
  const { tone, words, says, why, changes } = found;
  return html`<div role="status" data-testid="verdict" id="verdict" class="verdict" data-outcome=${report.outcome} data-proven=${report.proven === false ? "false" : "true"} data-tone=${tone}><h2>${words}</h2><p>${says} ${why}</p>${told?.crank ? html`<p class="of" id="result-of">${crankName(told.crank)}, ${new Date(told.started).toLocaleString(locale)}</p>` : ""}
    ${tone === "stale" ? html`<ul id="job-changed" data-testid="job-changed" aria-label=${t("Changed since then")}>${changes.slice(0, 3).map((each) => html`<li>${changeText(each)}</li>`)}${changes.length > 3 ? html`<li>${t("and {count} more", { count: changes.length - 3 })}</li>` : ""}</ul><p class="buttons"><button type="button" data-testid="cut-again" onClick=${() => balance()}>${t("Cut again")}</button> <button type="button" data-testid="job-of" onClick=${() => back(told)}>${t("Job of this result")}</button></p>` : ""}</div><p data-testid="reason" id="reason">${said(report.reason)}</p>`;
}
// The job as it was when this result was made.
const back = guarded(async (told) => {
  await brought(() => post("/api/open", { run: told.id }));
  changed();
});

// What would suffice where the limits do not: each change is a button, the first one the main button of the step.
export const remedies = () => (state.result?.report.relaxations || []).filter(({ changes }) => changes.length).map(({ text, changes }) => {
  const values = Object.fromEntries(changes.map(({ key, proposed }) => [key, proposed]));
  return { words: said(text), values, work: () => { applied(values); balance(); } };
});
function Remedies() {
  return html`<div id="relaxations" data-testid="relaxations" class="buttons">${remedies().map(({ words, values, work }) => html`<button type="button" data-changes=${JSON.stringify(values)} onClick=${work}>${t("Try {change}", { change: words })}</button>`)}</div>`;
}

const PAPERS = [["For the machinist", ["sheet.pdf", "holes.csv", "drawing.dxf"]], ["For the balancing machine", ["bob-weights.pdf", "reading.toml"]], ["For the customer", ["certificate.pdf", "report.html", "history.html", "crank-before.png", "crank-after.png"]]];

// The name of a saved file, as the server gives it too: of its crank, from the second stage on its stage.
const savedName = (told, name) => [asFileName(crankName(told?.crank)), told?.stage > 1 ? `stage-${told.stage}` : "", name].filter(Boolean).join("-");

// Files by who needs them; each is saved under a name that starts with the crank's.
function Files() {
  const { id, report, told, papers = [] } = state.result || {}, solid = report?.outputs.solid?.file;
  if (!report) return "";
  const link = (name, words, more = {}) => html`<a href=${`/api/runs/${id}/${more.room || "files"}/${encodeURIComponent(name)}`} download=${savedName(told, name)} data-file=${name} id=${more.id} data-testid=${more.id}>${t(words)}</a>${name.endsWith(".pdf") ? html` <a class="print" target="_blank" data-print=${name} href=${`/api/runs/${id}/${more.room || "files"}/${name}?show`} aria-label=${`${t("Print")}: ${t(words)}`}>${t("Print")}</a>` : ""} `;
  const files = (told?.files || []).filter((name) => name !== "report.json" && name !== solid), grouped = PAPERS.flatMap(([, names]) => names);
  const known = (name) => (files.includes(name) ? link(name, FILES[name] || name) : papers.includes(name) ? link(name, FILES[name] || name, { room: "papers" }) : "");
  const others = [...files, ...papers].filter((name) => !grouped.includes(name));
  return html`<div id="downloads" data-testid="papers"><h2>${t("Documents")}</h2>${PAPERS.map(([words, names]) => html`<p><small>${t(words)}</small>${names.map(known)}</p>`)}
    <p><small>${t("For you")}</small>${solid ? link(solid, "Corrected solid", { id: "download-solid" }) : ""}${link("report.json", "Report", { id: "download-report" })}${others.map(known)}<button type="button" id="download-job" hidden=${!told?.crank} onClick=${saveJob}>${t("Job")}</button></p></div>`;
}

// Before to after.
function Look() {
  const share = look.fade / 100;
  const fade = ({ target }) => { look.fade = Number(target.value); view.fade(1 - look.fade / 100); redraw(); };
  return html`<div class="fields view-fields"><label class="slider"><span>${t("Before to after")}</span><input type="range" id="fade" data-testid="fade" min="0" max="100" value=${look.fade} aria-valuetext=${share === 0 ? t("before") : share === 1 ? t("after") : `${look.fade} % ${t("after")}`} onInput=${fade}/></label></div>`;
}
