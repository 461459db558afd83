// Engine and targets: what a job usually says of them, in the order in which people know it.
import { html } from "/static/preact.min.js";
import { JobField } from "/static/fields.js";
import { at, changed, isWas, keep, state } from "/static/job.js";
import { Seg, preview, showBefore } from "/static/parts.js";
import { shown, withUnit } from "/static/tools.js";
import { t } from "/static/words.js";

export const declared = (table, key) => state.declared.tables.find((each) => each.table === table).keys.find((each) => each.key === key);
const PLACE = [["engine", "rod_length_mm"], ["engine", "rods_per_throw"], ["engine", "layout.bank_deg"], ["engine", "layout.kind"], ["engine", "turns"], ["cycle", "bore_mm"], ["cycle", "compression_ratio"], ["cycle", "heat_J"], ["cycle", "firing_order"], ["cycle", "flywheel_kg_mm2"]];
const VERDICT = [["balance", "margin"], ["balance", "tolerance_planes_mm"], ["balance", "overbalance_g_mm"], ["balance", "external"]];
const LISTS = [["engine", "attached"], ["balance", "external_part"], ["engine", "throw"]];
const PAPERS = ["customer", "engine", "serial", "operator", "note"].map((key) => ["job", key]);
export const SHOWN = [...PLACE, ...VERDICT, ...LISTS, ...PAPERS];
const HALVES = { 45: "45°", 60: "60°", 72: "72°", 90: "90°", 180: "180°" };

export function Targets() {
  const named = (key, id, words) => html`<${JobField} table="balance" field=${declared("balance", key)} id=${id} testid=${id} label=${words} list=${id === "grade" ? "grades" : undefined}/>`;
  const found = preview.value.found, isKept = at("balance.factor") === "original", makers = found?.balance_factor.makers;
  const choose = (kind) => { if (kind === "makers") showBefore(); keep("balance.factor", kind === "makers" ? "original" : typeof makers === "number" ? Math.round(1e4 * makers) / 1e4 : undefined); changed(); };
  const makersWords = typeof makers === "number" ? t("Keep the maker's {factor}", { factor: shown(makers, 3) }) : t("Keep the maker's");
  return html`<h2>${t("Balance factor")}</h2><${Seg} name="factor-of" label=${t("Balance factor")} options=${[["makers", makersWords], ["mine", t("Mine")]]} now=${isKept ? "makers" : "mine"} set=${choose}/>
    ${isKept && !isWas() ? html`<p class="note" role="alert">${t("Enter what the parts weighed before, in the column was.")}</p>` : ""}
    <div class="fields" id="targets">${isKept ? html`<label>${t("Wanted factor")} <output id="factor-kept" data-testid="factor-kept">${shown(found?.balance_factor.target, 3)}</output></label>` : named("factor", "factor", `${t("Wanted factor")} [0–1]`)}${named("speed_rpm", "speed-rpm", `${t("Highest speed")} [1/min]`)}${named("grade", "grade", `${t("Grade G")} [mm/s]`)}</div>
    <datalist id="grades">${state.declared.grades.map(({ grade, machinery }) => html`<option value=${grade}>${machinery}</option>`)}</datalist>`;
}

export function Engine() {
  const fields = (list) => list.map(([table, key]) => html`<${JobField} table=${table} field=${declared(table, key)}/>`);
  return html`<details id="engine"><summary>${t("Engine")} <small>${facts()}</small></summary>
    <div class="fields wide"><label>${t("Layout")}<select id="layout" data-testid="layout" value=${layout()} onInput=${({ target }) => lay(target.value)}>
      <option value="line">${t("in line: one rod on a pin")}</option>${Object.entries(HALVES).map(([angle, text]) => html`<option value=${angle}>${t("V {angle}: two rods on a pin", { angle: text })}</option>`)}
      ${layout() === "own" ? html`<option value="own">${t("as the job has it")}</option>` : ""}</select></label>${fields(PLACE)}</div>
    <details id="verdict-keys"><summary>${t("Planes, margin, what is left on purpose")}</summary><div class="fields wide">${fields(VERDICT)}</div></details>
    <details id="lists"><summary>${t("Attached parts, external parts, throws that differ")}</summary>${fields(LISTS)}</details>
    <details id="paper-keys"><summary>${t("On the certificate: customer, engine, serial number")}</summary><div class="fields wide">${fields(PAPERS)}</div></details></details>`;
}

// The layout as rods on a pin and their banks say it.
function layout() {
  const rods = at("engine.rods_per_throw") ?? 1, bank = at("engine.layout.bank_deg");
  if (rods === 1 && (bank === undefined || bank === 0)) return "line";
  if (rods === 2 && Array.isArray(bank) && bank.length === 2 && bank[0] === -bank[1] && 2 * bank[1] in HALVES) return String(2 * bank[1]);
  return "own";
}
function lay(angle) {
  const between = Number(angle) / 2;
  keep("engine.rods_per_throw", angle === "line" ? undefined : 2);
  keep("engine.layout.bank_deg", angle === "line" ? undefined : [-between, between]);
  changed();
}

// What crank and keys together say: cylinders, stroke, displacement, rod ratio.
function facts() {
  const throws = state.inspected?.report.crank?.throws;
  if (!throws?.length) return "";
  const cylinders = throws.length * (at("engine.rods_per_throw") ?? 1), stroke = 2 * throws[0].crank_radius_mm, bore = at("cycle.bore_mm"), rod = at("engine.rod_length_mm");
  const found = [cylinders === 1 ? t("1 cylinder") : t("{count} cylinders", { count: cylinders }), `${t("stroke")} ${withUnit(stroke, 2, "mm")}`];
  if (typeof bore === "number") found.push(`${shown((cylinders * Math.PI * bore ** 2 * stroke) / 4e3, 0)} cm³`);
  if (typeof rod === "number") found.push(`${t("rod to stroke")} ${shown(rod / stroke, 2)}`);
  return found.join(", ");
}
