// What an analysis reads beside the job: a file of its own, as fields and as text; records; options of its command.
import { html } from "/static/preact.min.js";
import { askJson, behind, guarded, put } from "/static/server.js";
import { debounced } from "/static/tools.js";
import { Any, Rows, keyOf, withKey } from "/static/fields.js";
import { redraw, signal } from "/static/store.js";
import { inWords, t } from "/static/words.js";

const files = {}; // verb → { tables, text } of its file
const options = {}; // verb → values of its command's options
const uploaded = signal([]); // names of the project's files
const open = new Set();
const editing = signal(""); // the verb whose file's text is being typed

export const fileOf = (verb) => files[verb]?.tables;
export const optionsOf = (verb) => options[verb] || {};
// Options that the job or the crank has already, until a person says otherwise.
const filled = new Set();
export function fillOptions(verb, values) {
  for (const [key, value] of Object.entries(values)) {
    if (filled.has(`${verb}.${key}`) || value === undefined || value === null) continue;
    filled.add(`${verb}.${key}`);
    options[verb] = withKey(optionsOf(verb), key, typeof value === "number" ? Number(value.toPrecision(7)) : value);
  }
}

const asked = new Set();
// The file of a verb, once it is looked at: the project's, else an example.
function loaded(verb) {
  if (asked.has(verb)) return;
  asked.add(verb);
  behind(async () => { files[verb] = await askJson(`/api/analyses/${verb}`); redraw(); })();
}
const listed = behind(async () => { uploaded.value = (await askJson("/api/project")).files; });

const kept = debounced(behind(async (verb) => { files[verb].text = (await put(`/api/analyses/${verb}`, { tables: files[verb].tables })).text; redraw(); }), 250);
function changed(verb, tables) {
  files[verb] = { ...files[verb], tables };
  redraw();
  kept(verb);
}
const typed = guarded(async (verb, toml) => {
  files[verb] = await put(`/api/analyses/${verb}`, { toml });
  editing.value = "";
  redraw();
});
const opened = (verb) => async ({ target }) => { if (target.files[0]) await typed(verb, await target.files[0].text()); };
const example = (verb) => guarded(async () => typed(verb, (await askJson(`/api/analyses/${verb}?example`)).text));

// --- the file of a verb -------------------------------------------------------------------------------------

export function OwnFile({ verb, tables }) {
  loaded(verb);
  const now = files[verb];
  if (!now) return html`<p class="quiet">…</p>`;
  const set = (path, value) => changed(verb, withKey(now.tables, path, value));
  return html`<p class="buttons"><label>${t("Open a file")} <input type="file" id=${`${verb}-open`} accept=".toml" onChange=${opened(verb)}/></label><button type="button" id=${`${verb}-example`} onClick=${example(verb)}>${t("Begin with an example")}</button></p>
    ${tables.map((each) => html`<${Table} key=${each.table} verb=${verb} now=${now.tables} set=${set} ...${each}/>`)}<${Text} verb=${verb} text=${now.text}/>`;
}

function Table({ verb, table, says, many, keys, now, set }) {
  const id = `${verb}-${table || "general"}`, place = table ? `${table}.` : "";
  const shown = keys.filter((key) => !key.of || !now.kind || key.of.includes(now.kind));
  const fields = () => html`<div class="fields wide">${shown.map((field) => html`<${Any} key=${field.key} id=${`${id}-${field.key.replaceAll(".", "-")}`} field=${field} now=${keyOf(now, place + field.key)} set=${(value) => set(place + field.key, value)}/>`)}</div>`;
  if (!table) return fields();
  const count = many ? (now[table] || []).length : Object.keys(now[table] || {}).length;
  const toggled = ({ target }) => { if (target.open) open.add(id); else open.delete(id); redraw(); };
  return html`<details open=${open.has(id)} ontoggle=${toggled}><summary>${inWords(table)} <small>${inWords(t(says))}${count ? `; ${t("{count} set", { count })}` : ""}</small></summary>
    ${!open.has(id) ? "" : many ? html`<${Rows} id=${id} field=${{ words: table, says, fields: keys }} now=${now[table]} set=${(value) => set(table, value)}/>` : fields()}</details>`;
}

function Text({ verb, text }) {
  if (editing.value !== verb) return html`<details><summary>${`${verb}.toml`} <small>${t("the same as text")}</small></summary><pre tabindex="0" id=${`${verb}-text`}>${text}</pre><button type="button" id=${`${verb}-edit`} onClick=${() => { editing.value = verb; }}>${t("Edit the text")}</button></details>`;
  const take = () => typed(verb, document.getElementById(`${verb}-toml`).value);
  return html`<label for=${`${verb}-toml`}>${`${verb}.toml`}</label><textarea id=${`${verb}-toml`} rows="16" spellcheck=${false} defaultValue=${text}></textarea>
    <p class="buttons"><button type="button" class="main" id=${`${verb}-take`} onClick=${take}>${t("Use this text")}</button><button type="button" onClick=${() => { editing.value = ""; }}>${t("Discard the changes")}</button></p>`;
}

// --- options of a command -----------------------------------------------------------------------------------

export function Options({ verb, fields }) {
  if (!fields.length) return "";
  const now = optionsOf(verb), set = (key) => (value) => { options[verb] = withKey(now, key, value); redraw(); };
  const required = fields.filter((field) => field.required), others = fields.filter((field) => !field.required);
  const shown = (some) => html`<div class="fields wide">${some.map((field) => html`<${field.kind === "file" ? FileChoice : Any} key=${field.key} id=${`${verb}-option-${field.key.replaceAll("_", "-")}`} field=${field} now=${now[field.key]} set=${set(field.key)}/>`)}</div>`;
  return html`${required.length ? shown(required) : ""}${others.length > 6 ? html`<details open><summary>${t("Options")}</summary>${shown(others)}</details>` : shown(others)}`;
}

// A file of the project, or one that is sent to it now.
function FileChoice({ id, field, now, set }) {
  if (!asked.has("files")) { asked.add("files"); listed(); }
  const sent = guarded(async ({ target }) => {
    const [file] = target.files;
    if (!file) return;
    const { file: name } = await askJson(`/api/files?name=${encodeURIComponent(file.name)}`, { method: "POST", body: file });
    await listed();
    set(name);
  });
  return html`<fieldset class="file-choice"><legend>${t(field.words)} <small>${inWords(t(field.says))}</small></legend>
    <select id=${id} aria-label=${t(field.words)} value=${now || ""} onInput=${({ target }) => set(target.value || undefined)}><option value="">${t("none")}</option>${uploaded.value.map((name) => html`<option>${name}</option>`)}</select>
    <input type="file" id=${`${id}-file`} aria-label=${`${t("Send a file")}: ${t(field.words)}`} onChange=${sent}/></fieldset>`;
}
