// See: the verdict and its numbers as measured, before and after, what was cut, doubts, plots, files.
import { $, el, withUnit } from "/static/tools.js";
import { askBuffer, askJson, guarded } from "/static/server.js";
import { applied, emit, on, state } from "/static/job.js";
import { balance } from "/static/correct.js";
import { Doubts, Numbers } from "/static/result.js";
import { outOf } from "/static/cuts.js";
import { mount, redraw } from "/static/store.js";
import { t } from "/static/words.js";
import * as drag from "/static/drag.js";

const OUTCOMES = { within_tolerance: "Within tolerance", already_within_tolerance: "Already within tolerance", above_tolerance: "Above tolerance" };
const FILES = { "report.html": "Report as a page", "sheet.pdf": "Shop sheet", "balance.xlsx": "Workbook",  "crank-before.png": "Picture before", "crank-after.png": "Picture after", "history.html": "History of stages", "reading.toml": "Reading to fill in", "certificate.pdf": "Certificate", "bob-weights.pdf": "Bob-weight card", "holes.csv": "List of holes", "drawing.dxf": "Drawing (DXF)" };
let view = null;

export function setUp(model) {
  view = model;
  mount(Numbers, $("result-numbers"));
  mount(Doubts, $("result-doubts"));
  on("look", (out) => view.turnTo(out));
  on("units", section);
  on("show", (told) => guarded(show)(told));
  on("begun", () => clear(t("Working …")));
  for (const name of ["forgotten", "gone"]) on(name, () => clear(t("No result yet")));
  $("fade").addEventListener("input", fade);
  for (const id of ["section", "section-at"]) $(id).addEventListener("input", section);
  $("download-job").addEventListener("click", () => save("job.toml", state.text));
}

function clear(words) {
  state.result = null;
  redraw();
  $("verdict").dataset.outcome = "";
  $("verdict").textContent = words;
  $("reason").textContent = "";
  for (const id of ["relaxations", "more-files"]) $(id).replaceChildren();
  drag.clear();
  for (const id of ["download-solid", "download-report"]) $(id).hidden = true;
}

export async function show(told) {
  const report = await askJson(`/api/runs/${told.id}/report`);
  clear("");
  state.result = { id: told.id, report, told };
  files(told, report);
  relaxations(report);
  const [left] = await Promise.all([drag.show(told), model(told.id)]);
  for (const name of left?.papers || []) $("more-files").append(el("a", { textContent: t(FILES[name] || name), href: `/api/runs/${told.id}/papers/${name}`, download: name }));
  drag.grips();
  if (report.corrections.length) view.turnTo(middle(report.corrections.map(outOf)), [0.15, 0.45, 0.7]);
  emit("result", state.result);
  $("reason").textContent = report.reason || "";
  const unproven = report.outcome !== "above_tolerance" && report.proven === false;
  $("verdict").textContent = t(OUTCOMES[report.outcome]) + (unproven ? t(", not proven") : "");
  $("verdict").title = unproven ? "Residual and uncertainty together exceed what is permitted." : "";
  $("verdict").dataset.outcome = report.outcome;
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
  fade();
}

// --- files ------------------------------------------------------------------------------------------------

function files(told, report) {
  const url = (name) => `/api/runs/${told.id}/files/${encodeURIComponent(name)}`;
  const link = (made, name) => Object.assign(made, { hidden: false, href: url(name), download: name });
  const solid = report.outputs.solid?.file;
  if (solid) link($("download-solid"), solid);
  link($("download-report"), "report.json");
  const more = told.files.filter((name) => name !== "report.json" && name !== solid);
  $("more-files").replaceChildren(...more.map((name) => link(el("a", { textContent: t(FILES[name] || name) }), name)));
}

function save(name, text) {
  const url = URL.createObjectURL(new Blob([text], { type: "application/toml" }));
  el("a", { href: url, download: name }).click();
  setTimeout(() => URL.revokeObjectURL(url), 1000);
}

// --- what would suffice -----------------------------------------------------------------------------------

function relaxations(report) {
  const found = (report.relaxations || []).filter(({ changes }) => changes.length);
  $("relaxations").replaceChildren(...found.map(({ text, changes }) => {
    const values = Object.fromEntries(changes.map(({ key, proposed }) => [key, proposed]));
    const made = el("button", { type: "button", textContent: `Try ${text}`, data: { changes: JSON.stringify(values) } });
    made.addEventListener("click", () => { applied(values); balance(); });
    return made;
  }));
}

// --- the view ---------------------------------------------------------------------------------------------

function fade() {
  const share = Number($("fade").value) / 100;
  $("fade").setAttribute("aria-valuetext", share === 0 ? "before" : share === 1 ? "after" : `${Math.round(100 * share)} % after`);
  view.fade(1 - share);
}

function section() {
  const axis = $("section").value, place = view.section(axis, Number($("section-at").value) / 100);
  $("section-at").disabled = axis === "none";
  $("section-says").textContent = place === null ? "" : `${axis} = ${withUnit(place, 1, "mm")}`;
}
