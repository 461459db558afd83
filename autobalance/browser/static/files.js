// Files and folders that are dropped or chosen: sent to the project, and opened.
import { html } from "/static/preact.min.js";
import { $, ending } from "/static/tools.js";
import { askJson, guarded, post } from "/static/server.js";
import { CRANKS, JOBS, USUAL, assumed, brought, changed, emit, state } from "/static/job.js";
import { list } from "/static/runs.js";
import { mount, signal } from "/static/store.js";
import { t } from "/static/words.js";

export const sent = signal(""); // what is being sent, by its names
export const over = signal(false); // something is held over the page
export const coming = signal(""); // the crank that is being sent
let opens = () => {};

export function setUp(open) {
  opens = open;
  mount(Target, $("drop-root"));
  for (const kind of ["dragenter", "dragover", "dragleave", "drop"]) document.addEventListener(kind, (event) => {
    if (!event.dataTransfer?.types.includes("Files")) return; // text that is dragged into a field
    event.preventDefault();
    over.value = kind !== "drop" && (kind !== "dragleave" || event.relatedTarget !== null);
    if (kind === "drop") filesOf(event.dataTransfer).then(dropped);
  });
}
// While files are held over the page, all of it is where they may be dropped.
function Target() {
  $("drop-root").hidden = !over.value;
  return over.value ? html`<p data-testid="drop-target">${t("Drop to open as a new crank")}</p>` : "";
}

async function filesOf(transfer) {
  const entries = [...transfer.items].map((item) => item.webkitGetAsEntry?.()).filter((entry) => entry);
  const folder = entries.find((entry) => entry.isDirectory);
  if (!folder) return [...transfer.files];
  const reader = folder.createReader(), inside = [];
  for (;;) {
    const some = await new Promise((resolve, reject) => reader.readEntries(resolve, reject));
    if (!some.length) break;
    inside.push(...some.filter((entry) => entry.isFile && !entry.name.startsWith(".")));
  }
  return Promise.all(inside.map((entry) => new Promise((resolve, reject) => entry.file(resolve, reject))));
}

const send = (file, apart) => askJson(`/api/files?name=${encodeURIComponent(file.name)}${apart ? `&apart=${apart}` : ""}`, { method: "POST", body: file });

let going = Promise.resolve();
export const sending = () => going;
// What was dropped is opened at once; a file without a unit in the unit that the page shows beside it.
export function dropped(files) {
  going = taking(files);
  going.then((isCrank) => isCrank && opens());
}
const taking = guarded(async (files) => {
  if (!files.length) return false;
  if (files.some((file) => CRANKS.includes(ending(file.name)))) Object.assign(assumed, USUAL); // not those of the file before; what is chosen while it is sent counts
  coming.value = files.find((file) => CRANKS.includes(ending(file.name)))?.name || "";
  sent.value = files.map((file) => file.name).join(", ");
  try {
    if (!files.some((file) => file.name === "report.json")) return await crankAndJob(files);
    await result(files);
  } finally { sent.value = coming.value = ""; }
  return false;
});

async function result(files) {
  const apart = [...crypto.getRandomValues(new Uint8Array(6))].map((each) => each.toString(16).padStart(2, "0")).join("");
  const { run } = await brought(async () => {
    for (const file of files) await send(file, apart);
    return post("/api/open", { file: "report.json", apart });
  });
  changed();
  list((await askJson("/api/runs")).runs);
  emit("show", await askJson(`/api/runs/${run}`));
  emit("tab", "see");
}

async function crankAndJob(files) {
  await brought(async () => {
    const kept = {};
    for (const file of files) kept[file.name] = (await send(file)).file;
    const names = Object.values(kept);
    const job = names.find((name) => JOBS.includes(ending(name))), crank = names.find((name) => CRANKS.includes(ending(name)));
    const answer = await post("/api/open", { file: job || crank || names[0] }), tables = answer.job;
    if (job && crank && tables.crankshaft && Object.keys(kept).includes(tables.crankshaft.file)) tables.crankshaft.file = kept[tables.crankshaft.file];
    return answer;
  }, true);
  changed();
  return (await askJson("/api/project")).files.includes(state.file);
}

// A crank to begin with: the bundled one with its weights, or one from a preset's dimensions.
export const example = guarded(async (preset, weighed = false) => {
  const model = $("model").dataset, before = model.state;
  model.state = "loading";
  try { state.cranks = (await brought(() => post("/api/example", { preset, weighed }), true)).cranks; } catch (error) { model.state = before; throw error; }
  changed();
  await opens();
});
