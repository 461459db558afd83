// Every key of a job as a field, made from the job's declarations.
import { html } from "/static/preact.min.js";
import { at, changed, keep, state } from "/static/job.js";
import { SHOWN } from "/static/engine.js";
import { JobField, Rows } from "/static/fields.js";
import { redraw } from "/static/store.js";
import { inWords, t } from "/static/words.js";

// Keys that have their place elsewhere on the page.
const ELSEWHERE = { crankshaft: ["file", "unit", "density_kg_m3", "crankpin_in_file"], engine: ["rotating_g", "reciprocating_g", "crankpin_g"], balance: ["factor", "grade", "speed_rpm", "judge"] };
const open = new Set();
let isOpen = false;

// All tables; their fields are made once they are opened.
export function Everything() {
  return html`<details id="everything" ontoggle=${({ target }) => { if (target.open !== isOpen) { isOpen = target.open; redraw(); } }}><summary>${t("All keys of the job")} <small>${t("every table of it, in the order of the job's page")}</small></summary>
    <div id="tables" data-testid="tables">${isOpen ? state.declared.tables.filter(({ table }) => table !== "original" && table !== "job").map((each) => html`<${Table} key=${each.table} ...${each}/>`) : ""}</div></details>`;
}

function Table({ table, says, many, keys }) {
  const shown = keys.filter(({ key }) => !ELSEWHERE[table]?.includes(key) && !SHOWN.some(([of, name]) => of === table && name === key));
  const set = many ? (at(table) || []).length : shown.filter(({ key }) => at(`${table}.${key}`) !== undefined).length;
  const toggled = ({ target }) => { if (target.open) open.add(table); else open.delete(table); };
  return html`<details open=${open.has(table)} ontoggle=${toggled}><summary>${inWords(table)} <small>${says}${set ? `; ${t("{count} set", { count: set })}` : ""}</small></summary>
    ${many ? html`<${Rows} id=${`key-${table}`} field=${{ words: table, says, fields: keys }} now=${at(table)} set=${(value) => { keep(table, value); changed(); }}/>` : html`<div class="fields wide">${shown.map((field) => html`<${JobField} key=${field.key} table=${table} field=${field}/>`)}</div>`}</details>`;
}
