// What the page knows: the crank, the parts, what is asked. It becomes the job that the commands take.
import { redraw } from "/static/store.js";
import { $, debounced, ending, typed } from "/static/tools.js";
import { askJson, behind, put } from "/static/server.js";
import { plain, t } from "/static/words.js";
import { correction, takeCorrection } from "/static/limits.js";
import { merged } from "/static/merged.js";

// Endings of crank files, and those of formats without a unit: the server writes them into the page.
const endings = (name) => $("panel-open").dataset[name].split(" ");
export const CRANKS = endings("cranks");
export const UNITLESS = endings("unitless");
export const JOBS = ["toml", "xlsx"];
export const GROUPS = { rotating_g: "Rotating", reciprocating_g: "Reciprocating", crankpin_g: "On or in the crankpin" };
export const state = {
  isKnown: false, // whether the project has told what it holds
  file: null,
  tables: {},
  declared: null, // kinds, tables, grades, parts: what forms are made of
  analyses: [], // { verb, says } of what cuts nothing
  presets: [], // names of cranks that can be drawn
  usual: {}, // group → { name of a part: what it is }, where nothing was weighed yet
  weights: { rotating_g: [], reciprocating_g: [], crankpin_g: [] },
  inspected: null, // { id, report } of the crank that is shown
  result: null, // { id, report, told } of the run that is shown
  ticks: {}, // number of a cut of the result → when it was done
  text: "",
  cranks: {}, // file → { name, scaled_from, factor, stroke_mm }: what is known beside the files
};
// What a crank is called: as its user named it, else as its file without the ending; and as a file's name may begin.
export const crankName = (file) => state.cranks[file || ""]?.name || (file || "").replace(/\.[^.]+$/, "");
export const asFileName = (name) => name.replace(/[\\/:*?"<>|]/g, "-").replace(/^\.+/, "");

const listeners = {};
export const on = (name, work) => (listeners[name] ||= []).push(work);
export const emit = (name, ...given) => {
  for (const work of listeners[name] || []) work(...given);
  redraw();
};

// A key of the job by its dotted path; tables that are empty once it is taken away go, too.
export const at = (path) => path.split(".").reduce((values, name) => values?.[name], state.tables);
export function keep(path, value) {
  const names = path.split("."), last = names.pop(), way = [state.tables];
  for (const name of names) way.push((way.at(-1)[name] ||= {}));
  if (value === undefined) delete way.at(-1)[last]; else way.at(-1)[last] = value;
  for (let k = names.length; k > 0 && !Object.keys(way[k]).length; k--) delete way[k - 1][names[k - 1]];
}

// What is taken for a file that does not say it, until the user says otherwise; another file begins with the usual again.
export const USUAL = { unit: "mm", density_kg_m3: 7850 };
export const assumed = { ...USUAL };
export const unitOfFile = () => at("crankshaft.unit") || assumed.unit;

// The unit of a file that has none is a question until it is answered: what is looked at meanwhile is taken in the usual one.
export const isUnitAsked = () => UNITLESS.includes(ending(state.file)) && !at("crankshaft.unit");
export function crankshaft(isLooking = true) {
  const found = { file: "", density_kg_m3: assumed.density_kg_m3, ...(state.tables.crankshaft || {}), file: state.file };
  if (state.file && !UNITLESS.includes(ending(state.file))) delete found.unit;
  else if (isLooking) found.unit = unitOfFile();
  return found;
}
// What is cut, compared or computed waits for the answer.
export function answered() {
  if (!state.file) throw new Error(t("Open a crank first."));
  if (isUnitAsked()) throw new Error(t("Answer 1 question in Crank: the unit of the file."));
}
// The job as it is looked at before anything is cut: in the unit that the page shows.
export const looked = () => ({ ...job(), crankshaft: crankshaft() });

function weight(row) {
  if (row.raw !== undefined) return row.raw;
  if (row.pm === "" && row.pieces === "") return typed(row.g);
  return { g: typed(row.g), ...(row.pm === "" ? {} : { pm: typed(row.pm) }), ...(row.pieces === "" ? {} : { pieces: typed(row.pieces) }) };
}

// What the parts weighed before, where any row says so: a row that says nothing was as it is, one of 0 g was not there.
export const isWas = () => Object.values(state.weights).some((rows) => rows.some((row) => String(row.was ?? "").trim() !== "" || row.wasRaw !== undefined));
function original() {
  if (!isWas()) return undefined;
  const made = {};
  for (const [group, rows] of Object.entries(state.weights)) {
    const before = byName(rows, (row) => row.wasRaw !== undefined || String(row.was ?? "").trim() !== "" || isWeighed(row), was);
    const named = Object.fromEntries(Object.entries(before).filter(([, value]) => value !== 0));
    if (Object.keys(named).length) made[group] = named;
  }
  return made;
}
function was(row) {
  if (row.wasRaw !== undefined) return row.wasRaw;
  const text = String(row.was ?? "").trim();
  return text === "" ? weight(row) : typed(text) === 0 ? 0 : weight({ ...row, raw: undefined, g: row.was, pm: "" });
}
const isWeighed = (row) => row.raw !== undefined || String(row.g).trim() !== "";

// Rows that say something, by the names they get in the job: a name that is there already gets a number.
function byName(rows, says = isWeighed, value = weight) {
  const named = {};
  for (const row of rows.filter(says)) {
    const name = row.name.trim() || "part";
    let free = name;
    for (let number = 2; free in named; number++) free = `${name}_${number}`;
    named[free] = value(row);
  }
  return named;
}

// What a group of rows weighs, in grams; null where the program alone can say.
export function sumOf(rows) {
  let sum = 0;
  for (const row of rows) {
    if (row.raw !== undefined) return null;
    const [g, pieces] = [typed(row.g || 0), row.pieces === "" ? 1 : typed(row.pieces)];
    if (typeof g !== "number" || typeof pieces !== "number") return null;
    sum += g * pieces;
  }
  return sum;
}

// The job as a file has it; free: planned again, though it lists its cuts.
export function job(isFree = false) {
  const engine = { ...(state.tables.engine || {}) };
  for (const group of Object.keys(GROUPS)) engine[group] = byName(state.weights[group]);
  if (!Object.keys(engine.crankpin_g).length) delete engine.crankpin_g;
  const { original: before, ...tables } = state.tables, kept = original();
  return { ...tables, ...(kept ? { original: { ...before, ...kept } } : {}), crankshaft: crankshaft(false), engine, balance: { ...(state.tables.balance || {}) }, correction: correction(state.tables.correction || {}, isFree) };
}

// Changes that the server does not have yet: what it has must not take their place.
let changes = 0, sent = 0;
export const edits = () => changes;
export const isKeptSince = (before) => sent === changes && changes === before;
let coming = 0; // jobs that were asked for and are not here yet
export const isComing = () => coming > 0;
let base = {}; // the job as it was saved last, or taken from the server
// A job of the server, with what was typed here since this page saved its own.
export const sinceSaved = (tables) => merged(base, job(), tables);
const save = behind(async () => {
  if (!state.file || sent === changes) return;
  const now = changes, tables = structuredClone(job());
  try { state.text = (await put("/api/job", tables)).job_text; } catch (error) {
    if (error.status !== 409) throw error;
    emit("clash", error.told);
    return;
  }
  sent = now;
  stepTaken(tables);
  base = tables;
  emit("saved");
  if (state.result?.told) state.result.told = await askJson(`/api/runs/${state.result.id}`);
  redraw();
});
// Steps back and forth through the job as it was saved; another crank's begin anew.
const past = [], future = [], MOST_STEPS = 100;
function stepped(from, to) {
  if (!from.length || sent !== changes) return false;
  to.push(structuredClone(job()));
  taken(from.pop());
  changed();
  return true;
}
export const undoJob = () => stepped(past, future);
export const redoJob = () => stepped(future, past);
function stepTaken(tables) {
  if (same(base, tables)) return;
  past.push(base);
  past.splice(0, past.length - MOST_STEPS);
  future.length = 0;
}
const kept = debounced(() => { if (!coming) save(); }, 250);

// Take the job that an answer brings, with what was typed while the answer was on its way; return the answer.
// Of another crank's job nothing goes over but that.
export async function brought(asks, isAnother = false) {
  const before = structuredClone(job()), then = changes;
  coming++;
  try {
    await save();
    const answer = await asks(), isTyped = changes !== then, now = job();
    const tables = isTyped ? merged(before, now, answer.job) : answer.job;
    if (isAnother) forget(isTyped);
    taken(tables);
    if (isTyped) base = merged(now, before, base); // what was typed is not saved yet
    return answer;
  } finally {
    coming--;
    if (sent !== changes) kept();
  }
}
// The same crank by another file: what is typed stays, steps of before would bring back the other solid.
export function ofFile(file, changes) {
  state.inspected = null;
  state.file = file;
  for (const [path, value] of Object.entries(changes)) keep(path, value);
  past.length = future.length = 0;
  emit("gone");
  changed();
}
function forget(isTyped) {
  state.inspected = state.file = null;
  state.tables = {};
  past.length = future.length = 0;
  if (!isTyped) for (const group of Object.keys(GROUPS)) state.weights[group] = [];
  emit("forgotten");
}

export function changed() {
  changes++;
  emit("job");
  kept();
}

// Take a job as the server has it: the page shows what it says and keeps what it does not show.
export function taken(tables) {
  for (const { unit, density_kg_m3: density } of [state.tables.crankshaft || {}, tables.crankshaft || {}]) {
    if (unit) assumed.unit = unit;
    if (typeof density === "number") assumed.density_kg_m3 = density;
  }
  state.tables = tables;
  const { crankshaft: crank = {}, engine = {} } = tables;
  state.file = crank.file || state.file;
  for (const group of Object.keys(GROUPS)) state.weights[group] = rowsOf(state.weights[group], engine[group] || {}, tables.original, group);
  const empty = Object.values(state.weights).every((rows) => !rows.length);
  if (empty) for (const group of Object.keys(GROUPS)) state.weights[group] = Object.entries(state.usual[group] || {}).map(([name, hint]) => ({ name, g: "", pm: "", pieces: "", hint }));
  takeCorrection(tables.correction || {});
  base = structuredClone(job());
  emit("taken");
}

// Rows for a group of weights; those that stand there stay as they are typed while they say the same.
function rowsOf(rows, weights, before, group) {
  const old = before?.[group] || {}, isSame = same(byName(rows), weights) && same(original()?.[group] || {}, before ? old : {});
  if (isSame) return rows;
  const gone = Object.keys(old).filter((name) => !(name in weights)).map((name) => ({ name, g: "", pm: "", pieces: "" }));
  return [...Object.entries(weights).map(rowOf), ...gone].map((row) => (before && !isOpen(before) ? { ...row, ...wasOf(row, old[row.name]) } : row));
}
const same = (one, other) => JSON.stringify(one) === JSON.stringify(other);
// A table of the parts before in which nothing was filled in is none.
const isOpen = (before) => Object.values(before).every((group) => typeof group !== "object" || !Object.keys(group).length);

function rowOf([name, value]) {
  const row = { name, g: "", pm: "", pieces: "" };
  if (typeof value !== "object") return { ...row, g: plain(value) };
  if (typeof value.g === "number" && Object.keys(value).every((key) => key in row)) return { ...row, ...Object.fromEntries(Object.entries(value).map(([key, each]) => [key, plain(each)])), name };
  return { ...row, raw: value };
}
function wasOf(row, value) {
  if (value === undefined) return { was: "0" };
  if (typeof value !== "object") return row.pieces === "" ? { was: plain(value) } : { wasRaw: value };
  const { g, pieces, ...rest } = value;
  return typeof g === "number" && !Object.keys(rest).length && plain(pieces ?? "") === row.pieces ? { was: plain(g) } : { wasRaw: value };
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
