// The kinds of correction with their limits, faces and angles: the job's [correction], as a form.
import { html, render } from "/static/preact.min.js";
import { $, el } from "/static/tools.js";
import { Field } from "/static/fields.js";
import { t } from "/static/words.js";

const WORDS = { faces: "", sector_deg: "", sectors_deg: "" };
export const kinds = { list: [], of: (name) => kinds.list.find((kind) => kind.name === name) };
export const faces = new Set(); // ids, and points of a job's file as JSON; none: chosen by the program
export const isPoint = (face) => face.startsWith("[");
export const zones = { list: [] }; // { from, to, allowed }
const given = {}; // kind → key → value
const TOP = ["faces", "sector_deg", "max_depth_mm", "same_depth", "min_wall_mm", "depth_step_mm"]; // may stand above the kinds' tables
let others = []; // methods of a job beyond the two that the form shows

let told = () => {};

export function setUp(list, changed) {
  kinds.list = list;
  told = changed;
  const options = () => list.map((kind) => el("option", { value: kind.name, textContent: kind.name === kind.noun.toLowerCase() ? kind.name : `${kind.name}: ${kind.noun.toLowerCase()}` }));
  $("method").replaceChildren(...options());
  $("also").replaceChildren(el("option", { value: "", textContent: t("nothing else") }), ...options());
  $("method").value = "drill";
  for (const id of ["method", "also"]) $(id).addEventListener("input", () => { others = []; shown(); told(); });
  $("add-zone").addEventListener("click", () => { zones.list.push({ from: 120, to: 240, allowed: true }); zoneRows(); told(); });
  $("add-forbidden").addEventListener("click", () => { zones.list.push({ from: 170, to: 190, allowed: false }); zoneRows(); told(); });
  shown();
}

export function methods() {
  const also = $("also").value;
  return [...(also && also !== $("method").value ? [$("method").value, also] : [$("method").value]), ...others];
}
const has = (key) => methods().some((name) => kinds.of(name)?.keys.some((each) => each.key === key));

// The form of the kinds that are chosen.
export function shown() {
  const chosen = methods().map(kinds.of).filter((kind) => kind);
  render(html`${chosen.map((kind) => html`<fieldset class="fields" key=${kind.name}><legend>${t("{kind}: limits", { kind: t(kind.noun) })}</legend>${kind.keys.filter(({ key }) => !(key in WORDS)).map((field) => html`<${Limit} kind=${kind.name} field=${field}/>`)}</fieldset>`)}`, $("limits"));
  $("faces-box").hidden = !has("faces");
  $("zones-box").hidden = !has("sector_deg") && !has("sectors_deg");
}

function Limit({ kind, field }) {
  const set = (value) => { (given[kind] ||= {})[field.key] = value; shown(); told(); };
  return html`<${Field} id=${`limit-${kind}-${field.key}`} field=${field} now=${given[kind]?.[field.key]} set=${set}/>`;
}

// The table [correction] of the job: what is filled in; keys that the page does not show stay.
export function correction(before) {
  const names = methods(), made = { ...before };
  for (const kind of kinds.list) delete made[kind.name];
  for (const key of TOP) delete made[key];
  made.method = names.length === 1 ? names[0] : names;
  for (const name of names) {
    const table = {};
    for (const { key } of kinds.of(name)?.keys || []) {
      if (key in WORDS) Object.assign(table, word(key));
      else if (given[name]?.[key] !== undefined) table[key] = given[name][key];
    }
    if (Object.keys(table).length) made[name] = table;
  }
  return made;
}

function word(key) {
  if (key === "faces") return faces.size ? { faces: [...faces].map((face) => (isPoint(face) ? JSON.parse(face) : face)) } : {};
  if (!zones.list.length) return {};
  const allowed = sectors();
  return key === "sectors_deg" ? { sectors_deg: allowed } : allowed.length === 1 ? { sector_deg: allowed[0] } : { sector_deg: widest(allowed) };
}
const span = ([from, to]) => (((to - from) % 360) + 360) % 360 || 360;
const widest = (list) => list.reduce((best, each) => (span(each) > span(best) ? each : best));

// What is allowed less what is forbidden, as intervals of angles.
export function sectors() {
  const wanted = zones.list.filter((zone) => zone.allowed).map(({ from, to }) => [from, to]);
  let left = wanted.length ? wanted : [[0, 360]];
  for (const { from, to } of zones.list.filter((zone) => !zone.allowed)) left = left.flatMap((each) => without(each, [from, to]));
  return left.length ? left : [[0, 0.001]]; // nowhere: the program says so
}

function without([from, to], [low, high]) {
  const length = span([from, to]), gone = span([low, high]), found = [];
  let begin = 0;
  const start = (((low - from) % 360) + 360) % 360;
  for (const at of [start - 360, start]) {
    const a = Math.max(at, 0), b = Math.min(at + gone, length);
    if (b <= a) continue;
    if (a > begin) found.push([begin, a]);
    begin = Math.max(begin, b);
  }
  if (begin < length) found.push([begin, length]);
  const turned = (angle) => Math.round(1e6 * (((from + angle) % 360 + 360) % 360)) / 1e6;
  return found.map(([a, b]) => [turned(a), turned(b) === 0 ? 360 : turned(b)]);
}

export function zoneRows() {
  $("zones").replaceChildren(...zones.list.map((zone, place) => {
    const input = (key, words) => {
      const made = el("input", { inputMode: "decimal", value: zone[key], "aria-label": `${zone.allowed ? "Allowed" : "Forbidden"} zone ${place + 1}: ${words} [degrees]` });
      made.addEventListener("input", () => { if (Number.isFinite(Number(made.value))) { zone[key] = Number(made.value); told(); } });
      return made;
    };
    const remove = el("button", { type: "button", textContent: "×", "aria-label": `Remove zone ${place + 1}` });
    remove.addEventListener("click", () => { zones.list.splice(place, 1); zoneRows(); told(); });
    return el("div", { className: "zone" }, el("span", { textContent: zone.allowed ? "allowed" : "forbidden" }), input("from", "from"), el("span", { textContent: "to" }), input("to", "to"), el("span", { textContent: "°" }), remove);
  }));
}

// Take the table of a job into the form.
export function takeCorrection(table) {
  const names = [].concat(table.method || "drill");
  if (kinds.of(names[0])) $("method").value = names[0];
  $("also").value = names[1] && kinds.of(names[1]) ? names[1] : "";
  others = names.slice(2).filter((name) => kinds.of(name));
  faces.clear();
  zones.list = [];
  for (const name of methods()) {
    const top = kinds.of(name)?.keys.some(({ key }) => key === "faces") ? table : {}; // as the job's reader has it
    given[name] = {};
    for (const { key } of kinds.of(name)?.keys || []) {
      const found = table[name]?.[key] ?? top[key];
      if (found === undefined || found === null) continue;
      if (key === "faces") { if (Array.isArray(found)) for (const face of found) faces.add(typeof face === "string" ? face : JSON.stringify(face)); }
      else if (key === "sector_deg") zones.list = [{ from: found[0], to: found[1], allowed: true }];
      else if (key === "sectors_deg") zones.list = found.filter(([a, b]) => !(a === 0 && b === 360)).map(([from, to]) => ({ from, to, allowed: true }));
      else given[name][key] = found;
    }
  }
  shown();
  zoneRows();
}
