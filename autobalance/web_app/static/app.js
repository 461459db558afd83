// The page: what the user knows goes into a job, the server's functions do the work, their numbers are shown.
import { View } from "/static/view.js";

const $ = (id) => document.getElementById(id);
const token = document.querySelector("meta[name=autobalance-token]").content;
const UNITLESS = ["stl", "obj", "ply", "off"];
const METHODS = ["shoulder", "turn", "drill", "slug", "add", "mill"];
const GROUPS = { rotating_g: "Rotating", reciprocating_g: "Reciprocating", crankpin_g: "On or in the crankpin" };
const OUTCOMES = { within_tolerance: "Within tolerance", already_within_tolerance: "Already within tolerance", above_tolerance: "Above tolerance" };

const state = { file: null, weights: { rotating_g: [], reciprocating_g: [], crankpin_g: [] }, extra: {}, run: null };
const view = new View($("model"), $("canvas"), $("model-note"));

// --- the server -------------------------------------------------------------------------------------------

async function ask(path, options = {}) {
  const answer = await fetch(path, { ...options, headers: { "X-Autobalance-Token": token, ...(options.headers || {}) } });
  if (!answer.ok) throw new Error((await answer.json().catch(() => ({ error: answer.statusText }))).error);
  return answer;
}
const askJson = async (path, options) => (await ask(path, options)).json();
const post = (path, body) => askJson(path, { method: "POST", body: JSON.stringify(body) });
const say = (text) => { $("error").textContent = text || ""; };

function guarded(work) {
  return async (...given) => {
    say("");
    try { await work(...given); } catch (error) { say(error.message); }
  };
}

// --- the job ----------------------------------------------------------------------------------------------

const number = (id) => { const text = $(id).value.trim(); return text === "" || !Number.isFinite(Number(text)) ? text : Number(text); };

function crankshaft() {
  const found = { ...(state.extra.crankshaft || {}), file: state.file, density_kg_m3: number("density") };
  delete found.unit; delete found.crankpin_in_file;
  if (UNITLESS.includes(ending(state.file))) found.unit = $("unit").value;
  if (!$("crankpin-in-file").checked) found.crankpin_in_file = false;
  return found;
}

function job() {
  const engine = { ...(state.extra.engine || {}) };
  for (const group of Object.keys(GROUPS)) {
    const rows = state.weights[group].filter((row) => row.name.trim());
    engine[group] = Object.fromEntries(rows.map((row) => [row.name.trim(), row.pm ? { g: Number(row.g) || 0, pm: Number(row.pm) } : Number(row.g) || 0]));
  }
  if (!Object.keys(engine.crankpin_g).length) delete engine.crankpin_g;
  const balance = { ...(state.extra.balance || {}), factor: number("factor"), grade: number("grade"), speed_rpm: number("speed-rpm"), judge: $("judge").value };
  const correction = { ...(state.extra.correction || {}), method: $("method").value };
  return { ...state.extra, crankshaft: crankshaft(), engine, balance, correction };
}

let waiting = null;
function changed() {
  bobWeights();
  clearTimeout(waiting);
  waiting = setTimeout(guarded(async () => {
    if (state.file) $("job-text").textContent = (await askJson("/api/job", { method: "PUT", body: JSON.stringify(job()) })).job_text;
  }), 250);
}

function taken(tables) {
  state.extra = tables;
  const { crankshaft = {}, engine = {}, balance = {}, correction = {} } = tables;
  state.file = crankshaft.file || state.file;
  if (crankshaft.unit) $("unit").value = crankshaft.unit;
  if (crankshaft.density_kg_m3) $("density").value = crankshaft.density_kg_m3;
  $("crankpin-in-file").checked = crankshaft.crankpin_in_file !== false;
  for (const group of Object.keys(GROUPS)) {
    state.weights[group] = Object.entries(engine[group] || {}).map(([name, value]) => typeof value === "object" ? { name, g: value.g ?? "", pm: value.pm ?? "" } : { name, g: value, pm: "" });
  }
  for (const [id, key] of [["factor", "factor"], ["grade", "grade"], ["speed-rpm", "speed_rpm"]]) if (balance[key] !== undefined) $(id).value = balance[key];
  if (balance.judge) $("judge").value = balance.judge;
  const method = Array.isArray(correction.method) ? correction.method[0] : correction.method;
  if (METHODS.includes(method)) $("method").value = method;
  fileChosen();
  weightRows();
}

// --- open -------------------------------------------------------------------------------------------------

const ending = (name) => (name || "").toLowerCase().split(".").pop();

function fileChosen() {
  $("chosen").textContent = state.file ? `${state.file}` : "No file yet";
  $("unit-field").hidden = !UNITLESS.includes(ending(state.file));
}

const upload = guarded(async (file) => {
  if (!file) return;
  $("chosen").textContent = `sending ${file.name} …`;
  const kept = await askJson(`/api/files?name=${encodeURIComponent(file.name)}`, { method: "POST", body: file });
  if (ending(kept.file) === "toml") {
    taken((await askJson("/api/project")).job);
    changed();
    return;
  }
  state.file = kept.file;
  if (state.extra.crankshaft) state.extra.crankshaft = { ...state.extra.crankshaft, file: kept.file };
  fileChosen();
  changed();
});

const open = guarded(async () => {
  if (!state.file) throw new Error("choose a crank file first");
  $("model").dataset.state = "loading";
  const told = await run("inspect", { crankshaft: crankshaft() });
  if (!told) { $("model").dataset.state = "empty"; return; }
  const report = await askJson(`/api/runs/${told.id}/report`);
  tree(report);
  view.show(await (await ask(`/api/runs/${told.id}/files/mesh.bin`)).arrayBuffer());
  if (report.crank.main_journals.length < 2) $("judge").value = "static";
  changed();
});

function tree(report) {
  const crank = report.crank, rows = [];
  const size = (value) => value.toPrecision(5).replace(/\.?0+$/, "");
  rows.push(["axis", 0, "Axis", `${size(crank.mass_g)} g`, [0, 0, 0], 2]);
  for (const pin of crank.main_journals) rows.push(["main_journal", pin.number, `Main journal ${pin.number}`, `⌀${size(pin.diameter_mm)} × ${size(pin.width_mm)} mm`, pin.centre_mm, pin.diameter_mm / 2]);
  for (const each of crank.throws) rows.push(["throw", each.number, `Throw ${each.number}`, `radius ${size(each.crank_radius_mm)} mm at ${size(each.angle_deg)}°`, each.crankpin.centre_mm, each.crankpin.diameter_mm / 2]);
  for (const web of crank.webs) {
    const z = (web.z_min_mm + web.z_max_mm) / 2, radius = web.outline ? web.outline.rim_radius_mm : 20;
    rows.push(["web", web.number, `Web ${web.number}`, `z ${size(web.z_min_mm)} to ${size(web.z_max_mm)} mm`, [0, 0, z], radius]);
    if (web.counterweight) rows.push(["counterweight", web.number, `Counterweight ${web.number}`, `rim radius ${size(radius)} mm`, [0, 0, z], radius]);
  }
  (report.faces || []).forEach((face, place) => rows.push(["face", place + 1, `Face ${face.id}`, `${size(face.area_mm2)} mm²`, face.centroid_mm, 3]));
  const list = $("tree");
  list.replaceChildren(...rows.map(([kind, count, name, told, centre, radius], place) => {
    const item = document.createElement("li");
    item.role = "treeitem"; item.tabIndex = place ? -1 : 0;
    item.dataset.kind = kind; item.dataset.number = count;
    item.setAttribute("aria-selected", "false");
    item.append(`${name} `, Object.assign(document.createElement("span"), { textContent: told }));
    const choose = () => {
      for (const other of list.children) other.setAttribute("aria-selected", String(other === item));
      view.point(centre, radius);
    };
    item.addEventListener("click", choose);
    item.addEventListener("keydown", (event) => {
      const next = { ArrowDown: item.nextElementSibling, ArrowUp: item.previousElementSibling }[event.key];
      if (next) { item.tabIndex = -1; next.tabIndex = 0; next.focus(); event.preventDefault(); }
      if (event.key === "Enter" || event.key === " ") { choose(); event.preventDefault(); }
    });
    return item;
  }));
}

// --- parts ------------------------------------------------------------------------------------------------

function weightRows() {
  $("weights").replaceChildren(...Object.entries(GROUPS).map(([group, title]) => {
    const box = document.createElement("div");
    box.className = "weights";
    box.append(Object.assign(document.createElement("h2"), { textContent: `${title} [g], ± [g]` }));
    state.weights[group].forEach((row, place) => box.append(weightRow(group, row, place)));
    const add = Object.assign(document.createElement("button"), { textContent: `Add a part` });
    add.dataset.testid = `add-${group}`;
    add.setAttribute("aria-label", `Add a part: ${title}`);
    add.addEventListener("click", () => { state.weights[group].push({ name: "", g: "", pm: "" }); weightRows(); document.querySelector(`[data-group=${group}]:last-of-type input`)?.focus(); });
    box.append(add);
    return box;
  }));
}

function weightRow(group, row, place) {
  const line = document.createElement("div");
  line.dataset.testid = "weight-row"; line.dataset.group = group;
  for (const [key, label] of [["name", "name"], ["g", "mass in grams"], ["pm", "plus or minus in grams"]]) {
    const input = document.createElement("input");
    input.dataset.testid = `weight-${key}`; input.value = row[key];
    input.setAttribute("aria-label", `${GROUPS[group]}, part ${place + 1}: ${label}`);
    if (key !== "name") input.inputMode = "decimal";
    input.addEventListener("input", () => { row[key] = input.value; changed(); });
    line.append(input);
  }
  const remove = Object.assign(document.createElement("button"), { textContent: "×" });
  remove.setAttribute("aria-label", `Remove ${row.name || "this part"}`);
  remove.addEventListener("click", () => { state.weights[group].splice(place, 1); weightRows(); changed(); });
  line.append(remove);
  line.addEventListener("paste", (event) => pasted(event, group, place));
  return line;
}

// Rows of a spreadsheet: name, grams, plus or minus.
function pasted(event, group, place) {
  const rows = event.clipboardData.getData("text").trim().split(/\r?\n/).map((text) => text.split("\t"));
  if (rows.length < 2 && rows[0].length < 2) return;
  event.preventDefault();
  state.weights[group].splice(place, 1, ...rows.map(([name, g = "", pm = ""]) => ({ name, g: g.replace(",", "."), pm: pm.replace(",", ".") })));
  weightRows();
  changed();
}

function bobWeights() {
  const sum = (group) => state.weights[group].reduce((total, row) => total + (Number(row.g) || 0), 0);
  const factor = Number($("factor").value);
  const rods = state.extra.engine?.rods_per_throw || 1;
  const bob = sum("crankpin_g") + rods * (sum("rotating_g") + factor * sum("reciprocating_g"));
  $("bob-weights").replaceChildren(
    Object.assign(document.createElement("dt"), { textContent: "Bob-weight of a throw, as typed" }),
    Object.assign(document.createElement("dd"), { textContent: Number.isFinite(bob) ? `${bob.toFixed(2)} g` : "" }));
  $("bob-weights").lastChild.dataset.predicted = String(bob);
}

// --- runs -------------------------------------------------------------------------------------------------

async function run(verb, given) {
  const { id } = await post("/api/runs", { verb, job: given });
  return follow(id);
}

async function follow(id) {
  state.run = id;
  $("cancel").disabled = false;
  try {
    for (;;) {
      const told = await askJson(`/api/runs/${id}`);
      progress(told);
      if (told.state === "done") return told;
      if (told.state === "cancelled") return null;
      if (told.state === "failed") throw new Error(told.error);
      await new Promise((resolve) => setTimeout(resolve, 120));
    }
  } finally {
    if (state.run === id) { state.run = null; $("cancel").disabled = true; }
    runList();
  }
}

function progress(told) {
  const share = Math.round(100 * told.share);
  $("progress").setAttribute("aria-valuenow", String(share));
  $("progress").firstElementChild.style.setProperty("width", `${share}%`);
  $("progress").lastElementChild.textContent = `${told.verb}: ${told.words}`;
}

const runList = guarded(async () => {
  const { runs } = await askJson("/api/runs");
  $("run-list").replaceChildren(...runs.slice(-8).reverse().map((each) => Object.assign(document.createElement("li"), { textContent: `${each.verb} ${each.id}: ${each.state}${each.error ? ` — ${each.error}` : ""}` })));
});

const balance = guarded(async () => {
  if (!state.file) throw new Error("open a crank first");
  $("balance").disabled = true;
  try {
    const told = await run("balance", job());
    if (told) { await result(told); select($("tab-see")); }
  } finally { $("balance").disabled = false; }
});

// --- see --------------------------------------------------------------------------------------------------

async function result(told) {
  const report = await askJson(`/api/runs/${told.id}/report`);
  $("verdict").dataset.outcome = report.outcome;
  $("verdict").textContent = OUTCOMES[report.outcome];
  $("reason").textContent = report.reason || "";
  const permitted = Object.fromEntries(report.tolerance.planes.map((plane) => [plane.name, plane.permissible_g_mm]));
  const rows = [["resultant", "", "magnitude_g_mm", report.tolerance.permissible_g_mm, "tolerance.permissible_g_mm"]];
  report.residual.planes.forEach((plane, place) => rows.push([`plane ${plane.name}`, `planes[${place}].`, "magnitude_g_mm", permitted[plane.name], `tolerance.planes[${place}].permissible_g_mm`]));
  const value = (of, path) => path ? of.planes[Number(path.match(/\d+/)[0])].magnitude_g_mm : of.magnitude_g_mm;
  $("numbers").tBodies[0].replaceChildren(...rows.map(([name, path, key, limit, limitKey]) => line([name, measured(`initial.${path}${key}`, value(report.initial, path)), measured(`residual.${path}${key}`, value(report.residual, path)), measured(limitKey, limit)])));
  $("cuts").tBodies[0].replaceChildren(...report.corrections.map((cut, place) => line([String(cut.number), cut.kind, String(cut.web ?? ""), measured(`corrections[${place}].depth_mm`, cut.depth_mm, 3), measured(`corrections[${place}].removed_mass_g`, cut.removed_mass_g)])));
  $("numbers").hidden = false; $("cuts").hidden = !report.corrections.length;
  const url = (name) => `/api/runs/${told.id}/files/${encodeURIComponent(name)}`;
  const link = (element, name) => { element.hidden = !name; if (name) { element.href = url(name); element.download = name; } };
  link($("download-solid"), report.outputs.solid && report.outputs.solid.file);
  link($("download-report"), "report.json");
  $("more-files").replaceChildren(...told.files.filter((name) => !["report.json", "mesh.bin"].includes(name) && !name.startsWith("balanced.")).map((name) => { const a = document.createElement("a"); link(a, name); a.textContent = name; return a; }));
  $("bob-card").textContent = report.engine.bob_weights.map((each) => `Throw ${each.throw}: bob-weight ${each.mass_g.toFixed(2)} g`).join("; ");
  view.show(await (await ask(url("mesh.bin"))).arrayBuffer());
}

function measured(key, value, digits = 2) {
  const cell = Object.assign(document.createElement("span"), { textContent: value === null ? "" : value.toFixed(digits) });
  cell.dataset.key = key; cell.dataset.value = String(value);
  return cell;
}

function line(cells) {
  const row = document.createElement("tr");
  row.append(...cells.map((cell) => { const td = document.createElement("td"); td.append(cell); return td; }));
  return row;
}

// --- tabs and start ---------------------------------------------------------------------------------------

const tabs = [...$("tabs").children];
function select(tab) {
  for (const each of tabs) {
    const on = each === tab;
    each.setAttribute("aria-selected", String(on)); each.tabIndex = on ? 0 : -1;
    $(each.getAttribute("aria-controls")).hidden = !on;
  }
}
tabs.forEach((tab, place) => {
  tab.addEventListener("click", () => select(tab));
  tab.addEventListener("keydown", (event) => {
    const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
    if (!step) return;
    const next = tabs[(place + step + tabs.length) % tabs.length];
    select(next); next.focus();
  });
});

$("method").replaceChildren(...METHODS.map((name) => Object.assign(document.createElement("option"), { textContent: name, value: name })));
$("method").value = "drill";
$("file-input").addEventListener("change", (event) => upload(event.target.files[0]));
$("open").addEventListener("click", open);
$("balance").addEventListener("click", balance);
$("cancel").addEventListener("click", guarded(async () => { if (state.run) await post(`/api/runs/${state.run}/cancel`, {}); }));
for (const id of ["unit", "density", "crankpin-in-file", "factor", "grade", "speed-rpm", "method", "judge"]) $(id).addEventListener("input", changed);
for (const kind of ["dragover", "dragleave", "drop"]) document.addEventListener(kind, (event) => {
  event.preventDefault();
  $("drop").classList.toggle("over", kind === "dragover");
  if (kind === "drop") upload(event.dataTransfer.files[0]);
});

await guarded(async () => {
  const project = await askJson("/api/project");
  taken(project.job);
  if (!state.file) {
    const crank = project.files.find((name) => [...UNITLESS, "3mf", "glb", "step", "stp"].includes(ending(name)));
    if (crank) { state.file = crank; fileChosen(); }
  }
  $("job-text").textContent = project.job_text;
  bobWeights();
  const { runs } = await askJson("/api/runs");
  const last = runs.filter((each) => each.verb === "balance" && each.state === "done").pop();
  if (last) await result(last);
  runList();
  const going = runs.find((each) => each.state === "running" && each.verb === "balance");
  if (going) guarded(async () => { const told = await follow(going.id); if (told) await result(told); })();
})();
document.body.dataset.ready = "true";
