// Parts: weights, targets and engine, and what they do to the crank as one types.
import { html, useEffect, useRef } from "/static/preact.min.js";
import { $, debounced, shown, withUnit } from "/static/tools.js";
import { post } from "/static/server.js";
import { GROUPS, changed, looked, on, state, sumOf } from "/static/job.js";
import { mount, redraw, signal } from "/static/store.js";
import { t } from "/static/words.js";
import { Engine, Targets } from "/static/engine.js";
import { Everything } from "/static/everything.js";
import { RodPicture } from "/static/rod-picture.js";

export const preview = signal({ found: null, why: "" });
const touched = signal(""); // the part whose row is being typed in

export function setUp() {
  on("job", ask);
  on("opened", ask);
  on("forgotten", () => { preview.value = { found: null, why: "" }; });
  mount(Parts, $("panel-parts"));
}

function Parts() {
  return html`<${Facts}/><p class="quiet" id="preview-why" aria-live="polite">${preview.value.why}</p>
    <div class="beside"><div><p class="quiet">${t("Weights of one connecting rod; crankpin parts of one throw. Rows of a spreadsheet may be pasted into any field.")}</p>
    <div id="weights">${Object.entries(GROUPS).map(([group, title]) => html`<${Group} group=${group} title=${t(title)}/>`)}</div></div><${RodPicture} part=${touched.value}/></div>
    <${Targets}/><${Engine}/><${Everything}/>`;
}

// --- weights ----------------------------------------------------------------------------------------------

function Group({ group, title }) {
  const rows = state.weights[group], added = useRef(false), box = useRef(null);
  useEffect(() => { if (added.current) [...box.current.querySelectorAll("[data-testid=weight-name]")].pop()?.focus(); added.current = false; });
  const total = sumOf(rows), open = rows.filter((row) => row.raw === undefined && String(row.g).trim() === "").length;
  const words = [total === null ? "" : t("{sum} g in all", { sum: shown(total, 2) }), open ? t("{count} not weighed: not in the job", { count: open }) : ""];
  const add = () => { rows.push({ name: "", g: "", pm: "", pieces: "" }); added.current = true; redraw(); };
  return html`<div class="weights" role="group" aria-label=${title} ref=${box}><h2>${title} <small>${t("name, pieces, g each, ± g")}</small></h2>
    ${rows.map((row, place) => html`<${Row} group=${group} title=${title} row=${row} place=${place}/>`)}
    <p class="quiet" data-testid=${`sum-${group}`}>${words.filter((each) => each).join("; ")}</p>
    <button type="button" aria-label=${`${t("Add a part")}: ${title}`} data-testid=${`add-${group}`} onClick=${add}>${t("Add a part")}</button></div>`;
}

const COLUMNS = [["name", "name"], ["pieces", "pieces"], ["g", "mass of each in grams"], ["pm", "plus or minus in grams"]];
function Row({ group, title, row, place }) {
  const cell = ([key, words]) => {
    const fixed = key !== "name" && row.raw !== undefined;
    const placeholder = fixed && key === "g" ? t("in the job") : key === "pieces" && !fixed ? "1" : "";
    return html`<input value=${row[key]} aria-label=${`${title}, ${t("part {number}", { number: place + 1 })}: ${t(words)}`} data-testid=${`weight-${key}`} inputMode=${key === "name" ? "text" : "decimal"}
      readOnly=${fixed} placeholder=${placeholder} title=${key === "name" ? t(row.hint || "") : ""} onFocus=${() => { touched.value = row.name; }} onInput=${({ target }) => { row[key] = target.value; changed(); }}/>`;
  };
  const remove = () => { state.weights[group].splice(place, 1); changed(); };
  return html`<div data-testid="weight-row" data-group=${group} onPaste=${(event) => pasted(event, group, place)}>${COLUMNS.map(cell)}<button type="button" aria-label=${t("Remove {name}", { name: row.name || t("this part") })} onClick=${remove}>×</button></div>`;
}

// Rows of a spreadsheet: name, grams, plus or minus; a row without a number is a heading.
function pasted(event, group, place) {
  const cells = event.clipboardData.getData("text").trim().split(/\r?\n/).map((text) => text.split("\t").map((cell) => cell.trim()));
  if (cells.length < 2 && cells[0].length < 2) return;
  event.preventDefault();
  const number = (text) => (text || "").replace(/\s*g$/, "").replace(",", ".");
  const found = cells.map(([name, g, pm]) => ({ name: name.replace(/\s+/g, "_"), g: number(g), pm: number(pm).replace("±", ""), pieces: "" })).filter((row) => row.name && row.g !== "" && Number.isFinite(Number(row.g)));
  state.weights[group].splice(place, 1, ...found);
  changed();
}

// --- as one types -----------------------------------------------------------------------------------------

let asked = 0;
const ask = debounced(async () => {
  if (!state.inspected) return;
  const mine = ++asked;
  let found = null, why = "";
  try { found = await post(`/api/runs/${state.inspected.id}/preview`, looked()); } catch (error) { why = error.message; }
  if (mine !== asked) return;
  if (found?.why) { why = found.why.replace(/^job\.toml: /, ""); found = null; }
  preview.value = { found, why };
}, 200);

const Predicted = ({ value, digits, unit = "" }) => html`<span class="predicted" data-predicted=${String(value)}>${unit ? withUnit(value, digits, unit) : shown(value, digits)}</span>`;

function Facts() {
  const { found } = preview.value;
  const facts = !found ? [] : [
    ...found.bob_weights.map((each) => [t("Bob-weight, throw {number}", { number: each.throw }), each.mass_g, "g"]),
    [t("Balance factor before"), found.balance_factor.initial, ""],
    [t("Unbalance before"), found.initial.magnitude_g_mm, "g·mm"],
    [t("Permitted"), found.tolerance.permissible_g_mm, "g·mm"],
  ];
  return html`<div id="preview" data-testid="preview" hidden=${!found}><h2>${t("Before anything is cut")} <small>${t("predicted from the measured crank")}</small></h2>
    <dl id="preview-facts">${facts.map(([name, value, unit]) => html`<dt>${name}</dt><dd><${Predicted} value=${value} digits=${unit ? 2 : 4} unit=${unit}/></dd>`)}</dl></div>`;
}
