// Open: files and folders dropped or chosen, the crank in a tree, what is in doubt, and what a user says of it.
import { $, arrows, el, ending, measured, withUnit } from "/static/tools.js";
import { askBuffer, askJson, askLeft, guarded, post, say } from "/static/server.js";
import { CRANKS, JOBS, UNITLESS, changed, crankshaft, emit, on, state, taken } from "/static/job.js";
import { unitOf } from "/static/units.js";
import { t } from "/static/words.js";
import { start } from "/static/runs.js";

let view = null;
let opening = 0;

export function setUp(shown) {
  view = shown;
  $("file-input").addEventListener("change", ({ target }) => {
    const files = [...target.files];
    target.value = ""; // the same file may be chosen again
    dropped(files);
  });
  $("open").addEventListener("click", async () => { await sending; open(); });
  $("unit").addEventListener("change", async () => { await sending; if (state.file) open(); });
  for (const kind of ["dragover", "dragleave", "drop"]) document.addEventListener(kind, (event) => {
    event.preventDefault();
    $("drop").classList.toggle("over", kind === "dragover");
    if (kind === "drop") filesOf(event.dataTransfer).then(dropped);
  });
  $("preset").replaceChildren(...state.presets.map((name) => el("option", { textContent: name })));
  $("bundled").addEventListener("click", () => example(null));
  $("draw-preset").addEventListener("click", () => example($("preset").value));
  arrows($("tree"), "[role=treeitem]");
  on("taken", chosen);
  on("units", () => { if (state.inspected) { tree(state.inspected.report); chosen(); } });
  for (const [id, key] of [["is-journal", "main_journals"], ["is-crankpin", "crankpins"], ["is-neither", null]]) $(id).addEventListener("click", () => override(key));
  $("forget-overrides").addEventListener("click", () => { for (const key of ["main_journals", "crankpins"]) delete state.tables.crankshaft?.[key]; changed(); open(); });
}

export function chosen() {
  $("chosen").textContent = state.file ? `${state.file}${size()}` : t("No file yet");
  $("unit-field").hidden = !UNITLESS.includes(ending(state.file));
  $("forget-overrides").hidden = !(state.tables.crankshaft?.main_journals || state.tables.crankshaft?.crankpins);
}

// How long the crank is in the unit that the page took: a wrong one is seen at once.
function size() {
  const report = state.inspected?.report;
  if (!report || !UNITLESS.includes(ending(state.file))) return "";
  const webs = report.crank.webs, ends = [...webs.map((web) => web.z_min_mm), ...webs.map((web) => web.z_max_mm)];
  return `: ${t("read in {unit}; {length} from the first web to the last", { unit: $("unit").value, length: withUnit(Math.max(...ends) - Math.min(...ends), 0, "mm") })}`;
}

// --- files ------------------------------------------------------------------------------------------------

async function filesOf(transfer) {
  const entries = [...transfer.items].map((item) => item.webkitGetAsEntry?.()).filter((entry) => entry);
  const folder = entries.find((entry) => entry.isDirectory);
  if (!folder) return [...transfer.files];
  const reader = folder.createReader(), found = [];
  for (;;) {
    const some = await new Promise((resolve, reject) => reader.readEntries(resolve, reject));
    if (!some.length) break;
    found.push(...some.filter((entry) => entry.isFile && !entry.name.startsWith(".")));
  }
  return Promise.all(found.map((entry) => new Promise((resolve, reject) => entry.file(resolve, reject))));
}

const send = (file, apart) => post0(`/api/files?name=${encodeURIComponent(file.name)}${apart ? `&apart=${apart}` : ""}`, file);
const post0 = (path, body) => askJson(path, { method: "POST", body });

let sending = Promise.resolve();
// What was dropped is opened at once; a file without a unit in the unit that the page shows beside it.
export function dropped(files) {
  sending = taking(files);
  sending.then((opens) => opens && open());
}
const taking = guarded(async (files) => {
  if (!files.length) return;
  const crank = files.find((file) => CRANKS.includes(ending(file.name)));
  if (crank) $("unit-field").hidden = !UNITLESS.includes(ending(crank.name));
  $("chosen").textContent = `sending ${files.map((file) => file.name).join(", ")} …`;
  try {
    if (files.some((file) => file.name === "report.json")) await result(files);
    else return await crankAndJob(files);
  } finally { chosen(); }
  return false;
});

async function result(files) {
  const apart = [...crypto.getRandomValues(new Uint8Array(6))].map((each) => each.toString(16).padStart(2, "0")).join("");
  for (const file of files) await send(file, apart);
  const { run, job } = await post("/api/open", { file: "report.json", apart });
  taken(job);
  changed();
  emit("show", await askJson(`/api/runs/${run}`));
  emit("tab", "see");
}

async function crankAndJob(files) {
  const kept = {};
  for (const file of files) kept[file.name] = (await send(file)).file;
  const names = Object.values(kept);
  const job = names.find((name) => JOBS.includes(ending(name))), crank = names.find((name) => CRANKS.includes(ending(name)));
  const other = job || crank || names[0];
  const { job: tables } = await post("/api/open", { file: other });
  if (job && crank && tables.crankshaft && Object.keys(kept).includes(tables.crankshaft.file)) tables.crankshaft.file = kept[tables.crankshaft.file];
  forget();
  taken(tables);
  changed();
  return (await askJson("/api/project")).files.includes(state.file);
}
// A crank to begin with: the bundled one with its weights, or one from a preset's dimensions.
const example = guarded(async (preset) => {
  const { job: tables } = await post("/api/example", { preset });
  forget();
  taken(tables);
  changed();
  await open();
});

function forget() {
  state.inspected = null;
  state.file = null;
  view.clear();
  $("tree").replaceChildren();
  emit("forgotten");
}

// --- the crank --------------------------------------------------------------------------------------------

let going = null; // what is being opened: asked twice, it is opened once
export function open() {
  const what = JSON.stringify(crankshaft());
  if (going?.what === what) return going.end;
  const mine = { what, end: opens().finally(() => { if (going === mine) going = null; }) };
  going = mine;
  return mine.end;
}
const opens = guarded(async () => {
  if (!state.file) throw new Error("choose a crank file first");
  const mine = ++opening;
  $("model").dataset.state = "loading";
  doubts([]);
  try {
    const told = await inspected();
    if (mine !== opening) return;
    opening++; // what was on its way meanwhile comes too late
    if (told) await show(told.id, true);
    else view.clear();
  } catch (error) {
    if (mine !== opening) return;
    opening++;
    view.clear();
    $("tree").replaceChildren();
    say(error.message);
    if (error.run) await unrecognised(error);
  }
});

// A crank of several bodies, or without crankpins, may be a pressed-up one: looked at as such, unless it was said.
async function inspected() {
  const asked = crankshaft();
  const look = (crank) => start("inspect", { job: { crankshaft: crank } }, state.file, meanwhile(opening));
  try { return await look(asked); } catch (error) {
    if (asked.crankpin_in_file !== undefined || !/bodies|crankpin|throw/.test(error.message)) throw error;
    try { return await look({ ...asked, crankpin_in_file: false }); } catch { throw error; }
  }
}

// The solid is shown as soon as it is built, while what is what in it is still being found out.
function meanwhile(mine) {
  let asked = false;
  return async (told) => {
    if (mine !== opening) return;
    if (!asked) view.say(`${told.words} …`);
    if (asked || !told.share) return;
    asked = true;
    const mesh = await askBuffer(`/api/runs/${told.id}/mesh`).catch(() => null); // the run tells what went wrong
    if (mesh && mine === opening) view.showCrank(mesh, false);
  };
}

export async function show(id, fresh = false) {
  const report = await askJson(`/api/runs/${id}/report`);
  state.inspected = { id, report };
  const found = await askLeft(`/api/runs/${id}/model`);
  if (fresh && found?.crankpin_in_file === false) $("crankpin-in-file").value = "false";
  const mesh = await askBuffer(`/api/runs/${id}/mesh`);
  if (mesh) view.showCrank(mesh);
  tree(report);
  cylinders();
  doubts(reasons(report));
  if (fresh && report.crank.main_journals.length < 2 && !state.tables.balance?.tolerance_planes_mm) $("judge").value = "static";
  chosen();
  emit("opened");
  if (fresh) changed();
}

// No crank was found: its solid and the cylinders in it, to say what is what.
async function unrecognised(error) {
  const mesh = await askBuffer(`/api/runs/${error.run}/mesh`);
  if (!mesh) return;
  view.showCrank(mesh);
  cylinders();
  doubts([error.message, ...(view.parts.length ? ["pick a cylinder in the model or in the list below, and say what it is"] : [])]);
}

function reasons(report) {
  const found = [...report.warnings], crank = report.crank;
  if (crank.journal_misalignment_mm > 0.01) found.push(el("span", {}, "the main journals are out of line by ", measured("crank.journal_misalignment_mm", crank.journal_misalignment_mm, 3), " mm"));
  const free = view.parts.filter((part) => part.kind === "cylinder").length;
  if (free) found.push(`${free} cylinder${free > 1 ? "s" : ""} along the axis taken for neither journal nor crankpin`);
  return found;
}
const doubts = (texts) => $("doubts").replaceChildren(...texts.map((text) => el("li", {}, text)));

// --- the tree ---------------------------------------------------------------------------------------------

const digits = (value) => (Math.abs(value) < 1e-3 ? 0 : Math.min(3, Math.max(0, 3 - Math.floor(Math.log10(Math.abs(value))))));
function number(key, value, unit) {
  const [, base, rest] = unit.match(/^(mm²|mm|kg·mm²|g|°|)(.*)$/);
  return [measured(key, value, digits(value)), `${base === "°" ? "" : " "}${unitOf(base)}${rest}`];
}

function tree(report) {
  const crank = report.crank, rows = [];
  rows.push(["axis", 1, "Axis", [...number("crank.mass_g", crank.mass_g, "g, "), ...number("crank.polar_inertia_kg_mm2", crank.polar_inertia_kg_mm2, "kg·mm²")], [0, 0, 0], 2]);
  crank.main_journals.forEach((pin, k) => rows.push(["main_journal", pin.number, `Main journal ${pin.number}`, ["⌀", ...number(`crank.main_journals.${k}.diameter_mm`, pin.diameter_mm, " × "), ...number(`crank.main_journals.${k}.width_mm`, pin.width_mm, "mm")], pin.centre_mm, pin.diameter_mm / 2]));
  crank.throws.forEach((each, k) => rows.push(["throw", each.number, `Throw ${each.number}`, ["radius ", ...number(`crank.throws.${k}.crank_radius_mm`, each.crank_radius_mm, "mm at "), ...number(`crank.throws.${k}.angle_deg`, each.angle_deg, "°")], each.crankpin.centre_mm, each.crankpin.diameter_mm / 2]));
  crank.webs.forEach((web, k) => {
    const z = (web.z_min_mm + web.z_max_mm) / 2, radius = web.outline ? web.outline.rim_radius_mm : 20;
    rows.push(["web", web.number, `Web ${web.number}`, ["z ", ...number(`crank.webs.${k}.z_min_mm`, web.z_min_mm, " to "), ...number(`crank.webs.${k}.z_max_mm`, web.z_max_mm, "mm")], [0, 0, z], radius]);
    if (web.counterweight) rows.push(["counterweight", web.number, `Counterweight ${web.number}`, web.outline ? ["rim radius ", ...number(`crank.webs.${k}.outline.rim_radius_mm`, radius, "mm")] : [], [0, 0, z], radius]);
  });
  (report.faces || []).forEach((face, k) => rows.push(["face", k + 1, `Face ${face.id}`, number(`faces.${k}.area_mm2`, face.area_mm2, "mm²"), null, 0]));
  $("tree").replaceChildren(...rows.map((each, place) => item(each, place)));
}

function item([kind, count, name, told, centre, radius], place) {
  const made = el("li", { role: "treeitem", tabIndex: place ? -1 : 0, "aria-level": kind === "axis" ? 1 : kind === "face" ? 3 : 2, "aria-selected": "false", data: { kind, number: String(count) } }, `${name} `, el("span", {}, ...told));
  const choose = () => selected(made, kind, count, centre, radius);
  made.addEventListener("click", choose);
  made.addEventListener("keydown", (event) => { if (event.key === "Enter" || event.key === " ") { choose(); event.preventDefault(); } });
  return made;
}

function selected(made, kind, count, centre, radius) {
  for (const other of $("tree").children) { other.setAttribute("aria-selected", String(other === made)); other.tabIndex = other === made ? 0 : -1; }
  const place = view.parts.findIndex((part) => part.kind === kind && part.number === count) + 1;
  view.mark(place ? [place] : []);
  view.point(place ? null : centre, radius);
  pickedPart(place);
}

// --- what a user says of a cylinder -----------------------------------------------------------------------

let picked = 0;

export function pickedInModel(hit) {
  const part = hit && hit.part ? view.parts[hit.part - 1] : null;
  view.mark(hit && hit.part ? [hit.part] : []);
  view.point(null);
  for (const each of $("tree").children) each.setAttribute("aria-selected", String(Boolean(part) && each.dataset.kind === part.kind && each.dataset.number === String(part.number)));
  $("tree").querySelector("[aria-selected=true]")?.scrollIntoView({ block: "nearest" });
  pickedPart(hit ? hit.part : 0);
}

function pickedPart(place) {
  const part = view.parts[place - 1];
  picked = part && part.file_centre_mm ? place : 0;
  $("cylinder").hidden = !picked;
  if (!picked) return;
  const now = { main_journal: `is main journal ${part.number}`, throw: `is the crankpin of throw ${part.number}`, cylinder: "was taken for neither journal nor crankpin" }[part.kind];
  $("cylinder-says").textContent = `This cylinder, ⌀${part.diameter_mm.toPrecision(5)} × ${part.width_mm.toPrecision(4)} mm, ${now}. It is`;
}

function cylinders() {
  const free = view.parts.flatMap((part, k) => part.kind === "cylinder" ? [[part, k + 1]] : []);
  $("cylinders").replaceChildren(...free.map(([part, place]) => {
    const made = el("button", { type: "button", textContent: `⌀${part.diameter_mm.toPrecision(4)} × ${part.width_mm.toPrecision(3)} mm` });
    made.addEventListener("click", () => { view.mark([place]); pickedPart(place); });
    return el("li", {}, made);
  }));
  $("cylinders-box").hidden = !free.length;
  $("cylinder").hidden = true;
}

const hint = (part) => ({ centre_mm: part.file_centre_mm, diameter_mm: part.diameter_mm, width_mm: part.width_mm });

function override(key) {
  const part = view.parts[picked - 1];
  if (!part) return;
  const lists = { main_journals: "main_journal", crankpins: "throw" };
  const table = (state.tables.crankshaft ||= {});
  for (const [list, kind] of Object.entries(lists)) {
    const kept = view.parts.filter((each) => each.kind === kind && each !== part).map(hint);
    if (list === key) table[list] = [...kept, hint(part)];
    else if (part.kind === kind && kept.length) table[list] = kept;
    else if (part.kind === kind) delete table[list];
  }
  chosen();
  changed();
  open();
}
