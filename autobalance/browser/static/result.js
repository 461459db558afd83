// A result in numbers: before, after, permitted; its doubts and its passes.
import { html } from "/static/preact.min.js";
import { shown } from "/static/tools.js";
import { Measured } from "/static/measured.js";
import { unitOf } from "/static/units.js";
import { t } from "/static/words.js";
import { state } from "/static/job.js";

const CAUSES = { facets: "facets of the file", rounding: "rounding of the file", axis: "the axis", density: "density", weights: "weights", attached: "attached parts", depth: "depths", machine: "the machine" };

// How the numbers are known: of the solid, or of a balancing machine.
function source({ command, corrections }) {
  const unit = { unit: unitOf("g·mm") };
  if (command !== "recut") return t("Measured on the written solid; unbalance in {unit}", unit);
  return corrections.length ? t("Reading and the cuts since, as measured on the written solid; unbalance in {unit}", unit) : t("Read on the balancing machine; unbalance in {unit}", unit);
}
export function Numbers() {
  const report = state.result?.report;
  if (!report) return html`<table id="numbers" hidden><tbody></tbody></table>`;
  const { initial, residual, tolerance, balance_factor: factor } = report, bob = report.engine.bob_weights[0];
  const rows = [[t("resultant"), initial, residual, tolerance.permissible_g_mm, "", "tolerance.permissible_g_mm"], ...residual.planes.map((plane, k) => [`${t("plane")} ${plane.name}`, initial.planes[k], plane, tolerance.planes[k].permissible_g_mm, `planes.${k}.`, `tolerance.planes.${k}.permissible_g_mm`])];
  const cell = (of, value, digits = 2) => html`<td><${Measured} of=${of} value=${value} digits=${digits}/></td>`;
  return html`<table id="numbers"><caption>${source(report)}</caption>
    <thead><tr><th></th><th scope="col">${t("before")}</th><th scope="col">${t("after")}</th><th scope="col">${t("permitted or target")}</th></tr></thead><tbody>
    ${rows.map(([name, before, after, limit, path, key]) => html`<tr><th scope="row">${name}</th>${cell(`initial.${path}magnitude_g_mm`, before.magnitude_g_mm)}${cell(`residual.${path}magnitude_g_mm`, after.magnitude_g_mm)}${cell(key, limit)}</tr>`)}
    ${bob ? html`<tr><th scope="row">${t("bob-weight, throw {number}", { number: 1 })} [g]</th><td></td>${cell("engine.bob_weights.0.mass_g", bob.mass_g)}<td></td></tr>` : ""}
    <tr><th scope="row">${t("balance factor")}</th>${cell("balance_factor.initial", factor.initial, 4)}${cell("balance_factor.final", factor.final, 4)}${cell("balance_factor.target", factor.target, 4)}</tr>
    <tr><th scope="row">${t("change of polar inertia")} [${unitOf("kg·mm²")}]</th><td></td>${cell("inertia_change_kg_mm2", report.inertia_change_kg_mm2)}<td></td></tr></tbody></table>`;
}

export function Doubts() {
  const report = state.result?.report;
  const shares = Object.entries(report?.residual.uncertainty_shares_g_mm || {}), together = report?.residual.uncertainty_g_mm, unstated = report?.residual.uncertainty_unstated || [];
  const line = (name, key, value) => html`<tr><th scope="row">${name}</th><td><${Measured} of=${key} value=${value} digits=${3}/></td></tr>`;
  return html`<details id="doubt-box" hidden=${!shares.length}><summary>${t("Uncertainty of the residual")}</summary>
    <table id="budget"><caption>${t("Causes, in {unit} of the resultant", { unit: unitOf("g·mm") })}</caption><thead><tr><th scope="col">${t("cause")}</th><th scope="col">±</th></tr></thead>
    <tbody>${shares.map(([cause, value]) => line(t(CAUSES[cause] || cause), `residual.uncertainty_shares_g_mm.${cause}`, value))}${together === null || together === undefined ? "" : line(t("together"), "residual.uncertainty_g_mm", together)}</tbody></table>
    <p class="quiet" id="unstated">${unstated.length ? t("No tolerance given, taken as 0: {causes}.", { causes: unstated.join(", ") }) : ""}</p></details>
    <details><summary>${t("Passes")}</summary><${Passes} steps=${report?.steps || []}/></details>`;
}

function Passes({ steps }) {
  const depths = (step) => step.depths_mm.map((depth) => shown(depth, 2, "mm")).join("; ");
  return html`<table id="steps" hidden=${!steps.length}><caption>${t("Resultant in {unit}", { unit: unitOf("g·mm") })}</caption>
    <thead><tr><th scope="col">${t("pass")}</th><th scope="col">${t("depths")} [${unitOf("mm")}]</th><th scope="col">${t("predicted")}</th><th scope="col">${t("measured")}</th></tr></thead>
    <tbody>${steps.map((step, k) => html`<tr><th scope="row">${step.step}</th><td>${depths(step)}</td><td><span class="predicted" data-predicted=${String(step.predicted_g_mm)}>${shown(step.predicted_g_mm, 3, "g·mm")}</span></td><td><${Measured} of=${`steps.${k}.measured_g_mm`} value=${step.measured_g_mm} digits=${3}/></td></tr>`)}</tbody></table>`;
}
