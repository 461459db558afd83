// What the page knows: the crank, the parts, what is asked. It becomes the job that the commands take.
import { $, debounced, ending, typed } from "/static/tools.js";
import { guarded, put } from "/static/server.js";
import { correction, takeCorrection } from "/static/limits.js";

// Endings of crank files, and those of formats without a unit: the server writes them into the page.
const endings = (name) => $("file-input").dataset[name].split(" ");
export const CRANKS = endings("cranks");
export const UNITLESS = endings("unitless");
export const JOBS = ["toml", "xlsx"];
export const GROUPS = { rotating_g: "Rotating", reciprocating_g: "Reciprocating", crankpin_g: "On or in the crankpin" };
const NUMBERS = { factor: "factor", grade: "grade", "speed-rpm": "speed_rpm" };

export const state = {
  file: null,
  tables: {},
  weights: { rotating_g: [], reciprocating_g: [], crankpin_g: [] },
  inspected: null, // { id, report } of the crank that is shown
  result: null, // { id, report, told } of the run that is shown
  text: "",
};

const listeners = {};
export const on = (name, work) => (listeners[name] ||= []).push(work);
export const emit = (name, ...given) => { for (const work of listeners[name] || []) work(...given); };

export function crankshaft() {
  const found = { ...(state.tables.crankshaft || {}), file: state.file, density_kg_m3: typed($("density").value) };
  delete found.unit;
  delete found.crankpin_in_file;
  if (UNITLESS.includes(ending(state.file))) found.unit = $("unit").value;
  if ($("crankpin-in-file").value !== "") found.crankpin_in_file = $("crankpin-in-file").value === "true";
  return found;
}

function weight(row) {
  if (row.raw !== undefined) return row.raw;
  return row.pm === "" ? typed(row.g || 0) : { g: typed(row.g || 0), pm: typed(row.pm) };
}

export function job() {
  const engine = { ...(state.tables.engine || {}) };
  for (const group of Object.keys(GROUPS)) {
    const rows = state.weights[group].filter((row) => row.name.trim());
    engine[group] = Object.fromEntries(rows.map((row) => [row.name.trim(), weight(row)]));
  }
  if (!Object.keys(engine.crankpin_g).length) delete engine.crankpin_g;
  const asked = Object.fromEntries(Object.entries(NUMBERS).map(([id, key]) => [key, typed($(id).value)]));
  const balance = { ...(state.tables.balance || {}), ...asked, judge: $("judge").value };
  return { ...state.tables, crankshaft: crankshaft(), engine, balance, correction: correction(state.tables.correction || {}) };
}

const kept = debounced(guarded(async () => {
  if (!state.file) return;
  state.text = (await put("/api/job", job())).job_text;
  $("job-text").textContent = state.text;
}), 250);

export function changed() {
  emit("job");
  kept();
}

// Take a job as the server has it: the page shows what it says and keeps what it does not show.
export function taken(tables) {
  state.tables = tables;
  const { crankshaft: crank = {}, engine = {}, balance = {} } = tables;
  state.file = crank.file || state.file;
  if (crank.unit) $("unit").value = crank.unit;
  if (typeof crank.density_kg_m3 === "number") $("density").value = crank.density_kg_m3;
  $("crankpin-in-file").value = crank.crankpin_in_file === undefined ? "" : String(crank.crankpin_in_file);
  for (const group of Object.keys(GROUPS)) state.weights[group] = Object.entries(engine[group] || {}).map(rowOf);
  for (const [id, key] of Object.entries(NUMBERS)) if (balance[key] !== undefined) $(id).value = balance[key];
  if (balance.judge) $("judge").value = balance.judge;
  takeCorrection(tables.correction || {});
  emit("taken");
}

function rowOf([name, value]) {
  if (typeof value !== "object") return { name, g: value, pm: "" };
  if (typeof value.g === "number" && Object.keys(value).every((key) => key === "g" || key === "pm")) return { name, g: value.g, pm: value.pm ?? "" };
  return { name, g: "", pm: "", raw: value };
}

// Change keys of the job by their dotted names, as `--set` does.
export function applied(changes) {
  const tables = structuredClone(job());
  for (const [path, value] of Object.entries(changes)) {
    const keys = path.split("."), last = keys.pop();
    let table = tables;
    for (const key of keys) table = table[key] ||= {};
    table[last] = value;
  }
  taken(tables);
  changed();
}
