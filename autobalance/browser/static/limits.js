// The kinds of correction with their limits, faces and angles: the job's [correction], as forms change it.
export const WORDS = { faces: "", sector_deg: "", sectors_deg: "" }; // keys with controls of their own
export const kinds = { list: [], of: (name) => kinds.list.find((kind) => kind.name === name) };
export const chosen = { method: "drill", also: "", others: [] }; // others: methods of a job beyond the two that the form shows
export const listed = { cuts: null }; // cuts that the job lists, to be made exactly so; null: they are planned
export const faces = new Set(); // ids, and points of a job's file as JSON; none: chosen by the program
export const isPoint = (face) => face.startsWith("[");
export const zones = { list: [] }; // { from, to, allowed }
const given = {}; // kind → key → value
const TOP = ["faces", "sector_deg", "max_depth_mm", "same_depth", "min_wall_mm", "depth_step_mm"]; // may stand above the kinds' tables

export function setUp(list) { kinds.list = list; }

export function methods() {
  const { method, also, others } = chosen;
  return [...(also && also !== method ? [method, also] : [method]), ...others];
}
export const has = (key) => methods().some((name) => kinds.of(name)?.keys.some((each) => each.key === key));
export const limitOf = (kind, key) => given[kind]?.[key];
export const setLimit = (kind, key, value) => { (given[kind] ||= {})[key] = value; };

// The table [correction] of the job: what is filled in; keys that the page does not show stay.
export function correction(before, isFree = false) {
  const names = methods(), made = { ...before };
  for (const kind of kinds.list) delete made[kind.name];
  delete made.cut;
  for (const key of TOP) delete made[key];
  made.method = names.length === 1 ? names[0] : names;
  for (const name of names) {
    const table = tableOf(name);
    if (Object.keys(table).length) made[name] = table;
  }
  if (isFree || !listed.cuts) return made;
  delete made.keep; // keeps places and plans depths: a list has both
  return { ...made, method: "listed", cut: listed.cuts };
}

// The limits of one kind as they are filled in, whether it is chosen or not.
export function tableOf(name) {
  const table = {};
  for (const { key } of kinds.of(name)?.keys || []) {
    if (key in WORDS) Object.assign(table, word(key));
    else if (given[name]?.[key] !== undefined) table[key] = given[name][key];
  }
  return table;
}

// A table [correction] with the limits of all kinds, as a comparison of them needs it.
export function ofAllKinds(made) {
  return { ...made, ...Object.fromEntries(kinds.list.map(({ name }) => [name, tableOf(name)]).filter(([, table]) => Object.keys(table).length)) };
}
// Another crank begins with the usual limits.
export function forgetLimits() {
  faces.clear();
  for (const name of Object.keys(given)) delete given[name];
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

// Take the table of a job into the form.
export function takeCorrection(table) {
  listed.cuts = [].concat(table.method).includes("listed") ? table.cut || [] : null;
  const names = listed.cuts ? [...new Set(listed.cuts.map(({ kind }) => kind))] : [].concat(table.method || "drill");
  if (kinds.of(names[0])) chosen.method = names[0];
  chosen.also = names[1] && kinds.of(names[1]) ? names[1] : "";
  chosen.others = names.slice(2).filter((name) => kinds.of(name));
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
}
