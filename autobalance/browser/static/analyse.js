// Analyses of the job: forces, the cycle, shafts and the like; each with the keys that it reads, its words, plots and files.
import { html } from "/static/preact.min.js";
import { $ } from "/static/tools.js";
import { askJson, askText, behind, guarded } from "/static/server.js";
import { answered, at, changed, job, keep, on, state } from "/static/job.js";
import { JobField, Rows } from "/static/fields.js";
import { OwnFile, Options, fileOf, optionsOf } from "/static/analysis-file.js";
import { cancel, last, list, runOf, running, start, watched } from "/static/runs.js";
import { mount, signal } from "/static/store.js";
import { labelOf } from "/static/verdict.js";
import { t } from "/static/words.js";

const chosen = signal("");
const done = signal([]); // { verb, id, files, words } of each that is done, the latest first
const open = new Set();

export function setUp() {
  mount(Analyse, $("panel-analyse"));
  on("saved", behind(async () => { if (done.value.length) list((await askJson("/api/runs")).runs); })); // a number may be an earlier job's now
}
export const known = (verb) => state.analyses.some((each) => each.verb === verb);

export const run = guarded(async () => {
  const name = verb(), { reads, options } = state.analyses.find((each) => each.verb === name), body = { options: optionsOf(name) };
  const missing = options.find(({ key, required }) => required && body.options[key] === undefined);
  if (missing) throw new Error(t("{name} is missing", { name: t(missing.words) }));
  if (["job", "both"].includes(reads)) {
    answered();
    body.job = job();
  }
  if (["file", "both"].includes(reads)) body.file = fileOf(name);
  const told = await watched(() => start(name, body));
  if (told) await show(told);
});

// An analysis that is done, before all others; one of the same kind gives way.
export async function show({ id, verb: name, files }) {
  const words = files.includes("summary.txt") ? await askText(`/api/runs/${id}/files/summary.txt`) : "";
  done.value = [{ id, verb: name, files, words }, ...done.value.filter((each) => each.verb !== name)];
}

const verb = () => chosen.value || state.analyses[0]?.verb;

const READS = { job: "From the job", both: "From the job and a file", file: "From a file", records: "From a recorded signal" };
const WHAT = { job: "Results for the job's engine, before any cut.", both: "Starts with the job's crank. Enter below what may change and what must be met.", file: "Needs no crank. Enter all values below.", records: "Needs no crank. Send a record and enter its data." };

function Analyse() {
  const now = state.analyses.find((each) => each.verb === verb());
  if (!now) return "";
  return html`<${Asked}/>${one(now)}`;
}

// What each analysis answers, and its number: of an earlier job it is grey.
const QUESTIONS = { factor: "Which balance factor?", forces: "How hard does it shake?", cycle: "Loads and torque over a cycle", strength: "Will it break?", shafts: "Balance shafts", parts: "What do the parts weigh?", torsion: "Torsional vibration", study: "How many of 1000 pass?", design: "Lighter counterweights", rotor: "Critical speeds", bearing: "Oil film of a bearing", bench: "Test bench", orders: "Orders in a recorded signal" };
function Asked() {
  return html`<div class="asked" data-testid="questions" role="group" aria-label=${t("Analyses")}>${state.analyses.map((each) => html`<${Question} key=${each.verb} ...${each}/>`)}</div>`;
}
function Question({ verb: name, reads }) {
  const failed = last(name)?.state === "failed" ? last(name) : null, found = failed ? null : done.value.find((each) => each.verb === name), going = running().find((each) => each.verb === name), isOld = Boolean(found && runOf(found.id)?.job_changed);
  const needs = failed ? t("needs: {what}", { what: missingOf(failed.error || "") }) : t("not run");
  return html`<button type="button" class=${`kind${verb() === name ? " chosen" : ""}`} aria-pressed=${String(verb() === name)} data-testid=${`question-${name}`} data-is=${going ? "running" : found ? (isOld ? "old" : "done") : failed ? "needs" : "new"} onClick=${() => { chosen.value = name; setTimeout(() => $("analysis").scrollIntoView({ block: "start" })); }}><b>${t(QUESTIONS[name] || name)}</b><span class="says">${going ? `${Math.round(100 * going.share)} %` : found ? `${isOld ? `${t("earlier job")}: ` : ""}${numberOf(found.words)}` : needs}</span><small>${name}${reads === "file" ? ` · ${t("own file")}` : ""}</small></button>`;
}
// What a run that failed lacks: the label of its key.
const missingOf = (error) => { const key = error.match(/^[^:]+: ([a-z_]+(?:\.[A-Za-z_]+)+) is missing/)?.[1]; return key ? labelOf(key) : error.replace(/^job\.toml: /, ""); };
// The first line of an answer that has a number.
const numberOf = (words) => words.split("\n").map((line) => line.trim().replace(/\s{2,}/g, " ")).filter((line, k) => k > 0 && /\d/.test(line))[0] || t("done");

function one(now) {
  const groups = Object.entries(READS).map(([reads, words]) => html`<optgroup label=${t(words)}>${state.analyses.filter((each) => each.reads === reads).map((each) => html`<option>${each.verb}</option>`)}</optgroup>`);
  return html`<div class="fields wide"><label>${t("Analysis")} <select id="analysis" data-testid="analysis" aria-describedby="analysis-says" value=${verb()} onInput=${({ target }) => { chosen.value = target.value; }}>${groups}</select></label></div>
    <p class="quiet" id="analysis-says">${t(now.says)}. ${t(WHAT[now.reads])}</p>
    ${now.tables.length ? html`<${OwnFile} key=${`file-${now.verb}`} verb=${now.verb} tables=${now.tables}/>` : ""}
    ${now.reads === "job" ? html`<${Read} key=${now.verb} by=${now.verb}/>` : ""}<${Options} key=${`options-${now.verb}`} verb=${now.verb} fields=${now.options}/>
    <${Going}/>
    <div id="analyses" data-testid="analyses" aria-live="polite">${done.value.map((each) => html`<${Done} key=${each.verb} ...${each}/>`)}</div>`;
}

// What is being computed, how far it is, and a button to end it.
function Going() {
  return running().filter((told) => known(told.verb)).map((told) => html`<div class="going" key=${told.id} data-testid="going"><progress max="1" value=${told.share} aria-label=${told.verb}></progress><span>${told.verb}: ${told.words}</span> <button type="button" aria-label=${`${t("Cancel")} ${told.verb}`} onClick=${guarded(() => cancel(told.id))}>${t("Cancel")}</button></div>`);
}

// The keys of the job that one analysis reads and not every one: as fields.
function Read({ by }) {
  const tables = state.declared.tables, own = tables.filter((each) => each.verbs.includes(by));
  const loose = tables.filter((each) => !own.includes(each) && !each.many).flatMap(({ table, keys }) => keys.filter((key) => key.verbs.includes(by)).map((field) => ({ table, field })));
  const toggled = (table) => ({ target }) => { if (target.open) open.add(table); else open.delete(table); };
  return html`<div id="analysis-reads">${loose.length ? html`<div class="fields wide">${loose.map(({ table, field }) => html`<${Single} by=${by} table=${table} field=${field}/>`)}</div>` : ""}
    ${own.map(({ table, says, many, keys }) => html`<details key=${table} open=${open.has(table)} ontoggle=${toggled(table)}><summary>${table} <small>${t(says)}</small></summary>
      ${many ? html`<${Rows} id=${`${by}-${table}`} field=${{ words: table, says, fields: keys }} now=${at(table)} set=${(value) => { keep(table, value); changed(); }}/>` : html`<div class="fields wide">${keys.map((field) => html`<${Single} by=${by} table=${table} field=${field}/>`)}</div>`}</details>`)}</div>`;
}
const Single = ({ by, table, field }) => html`<${JobField} key=${field.key} id=${`${by}-${table}-${field.key.replaceAll(".", "-")}`} table=${table} field=${field}/>`;

function Done({ id, verb: name, files, words }) {
  const url = (file) => `/api/runs/${id}/files/${encodeURIComponent(file)}`;
  const pictures = files.filter((file) => /\.(svg|png)$/.test(file)), others = files.filter((file) => !pictures.includes(file));
  return html`<section id=${`analysis-${name}`}><h2>${name}</h2>
    ${words ? html`<pre tabindex="0" aria-label=${t("Summary of {verb}", { verb: name })}>${words}</pre>` : ""}
    ${pictures.length ? html`<div class="plots">${pictures.map((file) => html`<figure key=${file}><a href=${url(file)} target="_blank"><img src=${url(file)} alt=${file.replace(/\.\w+$/, "").replaceAll("-", " ")} loading="lazy"/></a></figure>`)}</div>` : html`<p class="quiet">${t("There is nothing to draw.")}</p>`}
    <p>${others.map((file) => html`<a href=${url(file)} download=${file}>${file}</a> `)}</p></section>`;
}
