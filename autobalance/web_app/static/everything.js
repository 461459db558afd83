// Every key of a job as a field, made from the job's declarations; and the job's text, to be typed.
import { $, el, listTyped, typed } from "/static/tools.js";
import { guarded, put } from "/static/server.js";
import { changed, emit, on, state, taken } from "/static/job.js";

// Keys that have their place elsewhere on the page.
const ELSEWHERE = { crankshaft: ["file", "unit", "density_kg_m3", "crankpin_in_file"], balance: ["factor", "grade", "speed_rpm", "judge"] };

export function setUp(tables) {
  const shown = tables.map(({ table, says, keys }) => ({ table, says, keys: keys.filter(({ key }) => !ELSEWHERE[table]?.includes(key)) }));
  const fill = () => $("tables").replaceChildren(...shown.map(form));
  on("taken", fill);
  fill();
  $("edit-job").addEventListener("click", () => { $("job-toml").value = state.text; editing(true); $("job-toml").focus(); });
  $("leave-job").addEventListener("click", () => editing(false));
  $("take-job").addEventListener("click", guarded(async () => {
    const { job } = await put("/api/job/text", { toml: $("job-toml").value });
    editing(false);
    taken(job);
    changed();
    emit("typed");
  }));
}

function editing(now) {
  $("job-edit").hidden = !now;
  $("job-text").hidden = $("edit-job").hidden = now;
}

function form({ table, says, keys }) {
  const set = keys.filter(({ key }) => at(table, key) !== undefined).length;
  const words = el("small", { textContent: ` ${says}${set ? `; ${set} set` : ""}` });
  return el("details", { open: open.has(table), ontoggle: ({ target }) => (target.open ? open.add(table) : open.delete(table)) }, el("summary", {}, table, words), el("div", { className: "fields wide" }, ...keys.map((each) => field(table, each))));
}
const open = new Set();

function field(table, { key, words, unit, kind, choices, default: usual, says }) {
  const now = at(table, key), id = `key-${table}-${key.replaceAll(".", "-")}`;
  const options = kind === "bool" ? [["true", "yes"], ["false", "no"]] : choices.map((each) => [each, each]);
  const input = options.length
    ? el("select", {}, el("option", { value: "", textContent: usual ? `usual: ${usual}` : "" }), ...options.map(([value, textContent]) => el("option", { value, textContent })))
    : el("input", { inputMode: kind === "number" ? "decimal" : "text", placeholder: usual });
  input.id = id;
  input.title = says;
  input.value = now === undefined ? "" : Array.isArray(now) ? now.join(", ") : String(now);
  input.disabled = typeof now === "object" && !Array.isArray(now); // a table in its place: in the text
  input.addEventListener("input", () => { keep(table, key, valueOf(input.value, kind)); changed(); });
  return el("label", {}, `${words}${unit ? ` [${unit}]` : ""}`, input);
}

function valueOf(text, kind) {
  if (text.trim() === "") return undefined;
  return { bool: () => text === "true", list: () => listTyped(text), number: () => typed(text) }[kind]?.() ?? text;
}

function at(table, key) {
  return key.split(".").reduce((values, name) => values?.[name], state.tables[table]);
}

// Set a key of the job, or take it away; tables that are empty then go, too.
function keep(table, key, value) {
  const names = [table, ...key.split(".")], last = names.pop(), way = [state.tables];
  for (const name of names) way.push((way.at(-1)[name] ||= {}));
  if (value === undefined) delete way.at(-1)[last]; else way.at(-1)[last] = value;
  for (let k = names.length; k > 0 && !Object.keys(way[k]).length; k--) delete way[k - 1][names[k - 1]];
}
