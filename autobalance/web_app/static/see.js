// See: the verdict and its numbers as measured, before and after, what was cut, doubts, plots, files.
import { $, el, measured, row, shown } from "/static/tools.js";
import { askBuffer, askJson, guarded } from "/static/server.js";
import { applied, emit, on, state } from "/static/job.js";
import { balance } from "/static/correct.js";
import { drawn } from "/static/polar.js";
import { t } from "/static/words.js";
import * as drag from "/static/drag.js";

const OUTCOMES = { within_tolerance: "Within tolerance", already_within_tolerance: "Already within tolerance", above_tolerance: "Above tolerance" };
const FILES = { "report.html": "Report as a page", "sheet.pdf": "Shop sheet", "balance.xlsx": "Workbook",  "crank-before.png": "Picture before", "crank-after.png": "Picture after", "history.html": "History of stages", "reading.toml": "Reading to fill in", "certificate.pdf": "Certificate", "bob-weights.pdf": "Bob-weight card", "holes.csv": "List of holes", "drawing.dxf": "Drawing (DXF)" };
const CAUSES = { facets: "facets of the file", rounding: "rounding of the file", axis: "the axis", density: "density", weights: "weights", attached: "attached parts", depth: "depths", machine: "the machine" };
let view = null;

export function setUp(model) {
  view = model;
  on("show", (told) => guarded(show)(told));
  on("begun", () => { clear(t("Working …")); });
  for (const name of ["forgotten", "gone"]) on(name, () => clear(t("No result yet")));
  $("fade").addEventListener("input", fade);
  for (const id of ["section", "section-at"]) $(id).addEventListener("input", section);
  $("download-job").addEventListener("click", () => save("job.toml", state.text));
}

function clear(words) {
  $("verdict").dataset.outcome = "";
  $("verdict").textContent = words;
  $("reason").textContent = "";
  for (const id of ["relaxations", "more-files"]) $(id).replaceChildren();
  drawn($("polars"), []);
  drag.clear();
  for (const id of ["numbers", "cuts", "cuts-says", "steps", "doubt-box", "download-solid", "download-report"]) $(id).hidden = true;
  for (const id of ["numbers", "cuts", "steps", "budget"]) $(id).tBodies[0].replaceChildren();
}

export async function show(told) {
  const report = await askJson(`/api/runs/${told.id}/report`);
  state.result = { id: told.id, report, told };
  clear("");
  numbers(report);
  cuts(report);
  budget(report);
  files(told, report);
  relaxations(report);
  const [left] = await Promise.all([drag.show(told), model(told.id)]);
  for (const name of left?.papers || []) $("more-files").append(el("a", { textContent: t(FILES[name] || name), href: `/api/runs/${told.id}/papers/${name}`, download: name }));
  drag.grips();
  emit("result", state.result);
  $("reason").textContent = report.reason || "";
  const unproven = report.outcome !== "above_tolerance" && report.proven === false;
  $("verdict").textContent = OUTCOMES[report.outcome] + (unproven ? ", not proven" : "");
  $("verdict").title = unproven ? "Residual and uncertainty together exceed what is permitted." : "";
  $("verdict").dataset.outcome = report.outcome;
}

async function model(id) {
  const buffer = await askBuffer(`/api/runs/${id}/view`);
  if (!buffer) return; // a result from elsewhere has no view
  view.showResult(buffer);
  fade();
}

function numbers(report) {
  const cell = (path, values) => measured(path, values, 2);
  const rows = [["resultant", "", report.tolerance.permissible_g_mm, "tolerance.permissible_g_mm"]];
  report.residual.planes.forEach((plane, k) => rows.push([`plane ${plane.name}`, `planes.${k}.`, report.tolerance.planes[k].permissible_g_mm, `tolerance.planes.${k}.permissible_g_mm`]));
  const at = (values, path) => (path ? values.planes[Number(path.split(".")[1])] : values);
  $("numbers").tBodies[0].replaceChildren(...rows.map(([name, path, limit, key]) => row([name, cell(`initial.${path}magnitude_g_mm`, at(report.initial, path).magnitude_g_mm), cell(`residual.${path}magnitude_g_mm`, at(report.residual, path).magnitude_g_mm), cell(key, limit)], 1)));
  const others = [["bob-weight, throw 1 [g]", "engine.bob_weights.0.mass_g", report.engine.bob_weights[0]?.mass_g], ["balance factor", "balance_factor", null], ["change of polar inertia [kg·mm²]", "inertia_change_kg_mm2", report.inertia_change_kg_mm2]];
  const factor = report.balance_factor;
  for (const [name, key, value] of others) {
    if (key === "balance_factor") $("numbers").tBodies[0].append(row([name, measured("balance_factor.initial", factor.initial, 4), measured("balance_factor.final", factor.final, 4), measured("balance_factor.target", factor.target, 4)], 1));
    else if (value !== null && value !== undefined) $("numbers").tBodies[0].append(row([name, "", measured(key, value, 2), ""], 1));
  }
  $("numbers").hidden = false;
  const plots = [["Resultant", report.initial, report.residual, report.tolerance.permissible_g_mm], ...report.residual.planes.map((plane, k) => [`Plane ${plane.name}`, report.initial.planes[k], plane, report.tolerance.planes[k].permissible_g_mm])];
  drawn($("polars"), plots.map(([name, before, after, permitted]) => [name, [{ ...before, name: "before" }, { ...after, name: "after" }], permitted]));
}

// Where each cut is, in the order of indexing; a click on a row turns the view to it.
function cuts(report) {
  $("cuts").tBodies[0].replaceChildren(...report.corrections.map((cut, k) => {
    const cell = (key, digits) => measured(`corrections.${k}.${key}`, cut[key], digits);
    const clockwise = el("small", { className: "quiet", textContent: ` (${shown((360 - cut.angle_deg) % 360, 1)})` });
    const made = row([turner(cut), cut.kind, String(cut.web ?? "–"), enteredFrom(cut), el("span", {}, cell("angle_deg", 1), clockwise), cell("radius_mm", 2), cell("z_mm", 2), cell("diameter_mm", 2), cell("depth_mm", 3), cell("removed_mass_g", 2)], 1);
    made.className = "turns";
    made.addEventListener("click", () => turnTo(cut, made));
    return made;
  }));
  for (const id of ["cuts", "cuts-says"]) $(id).hidden = !report.corrections.length;
  $("steps").tBodies[0].replaceChildren(...report.steps.map((step, k) => row([String(step.step), step.depths_mm.map((depth) => depth.toFixed(2)).join(", "), el("span", { className: "predicted", textContent: step.predicted_g_mm.toFixed(3), data: { predicted: String(step.predicted_g_mm) } }), measured(`steps.${k}.measured_g_mm`, step.measured_g_mm, 3)], 1)));
  $("steps").hidden = !report.steps.length;
}

// Which way the tool comes from, as a unit vector out of the metal.
function outOf(cut) {
  if (cut.inward) return cut.inward.map((each) => -each);
  return cut.side ? [0, 0, cut.side] : [cut.position_mm[0], cut.position_mm[1], 0];
}
function enteredFrom(cut) {
  const along = outOf(cut)[2];
  return Math.abs(along) > 0.9 ? (along > 0 ? "+z" : "−z") : "rim";
}
// The number of a cut, as a button: the view turns to it by keys too.
function turner(cut) {
  return el("button", { type: "button", textContent: String(cut.number), "aria-label": `Cut ${cut.number}: turn the view to it`, data: { testid: "turn-to", cut: String(cut.number) } });
}
function turnTo(cut, made) {
  for (const each of $("cuts").tBodies[0].rows) each.setAttribute("aria-selected", String(each === made));
  emit("look");
  view.turnTo(outOf(cut));
}

function budget(report) {
  const shares = report.residual.uncertainty_shares_g_mm || {};
  const rows = Object.entries(shares).map(([cause, value]) => row([CAUSES[cause] || cause, measured(`residual.uncertainty_shares_g_mm.${cause}`, value, 3)], 1));
  if (report.residual.uncertainty_g_mm !== null && report.residual.uncertainty_g_mm !== undefined) rows.push(row(["together", measured("residual.uncertainty_g_mm", report.residual.uncertainty_g_mm, 3)], 1));
  $("budget").tBodies[0].replaceChildren(...rows);
  $("unstated").textContent = report.residual.uncertainty_unstated?.length ? `Not stated in the job, so counted as nothing: ${report.residual.uncertainty_unstated.join(", ")}.` : "";
  $("doubt-box").hidden = !rows.length;
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
  $("section-says").textContent = place === null ? "" : `${axis} = ${place.toFixed(1)} mm`;
}
