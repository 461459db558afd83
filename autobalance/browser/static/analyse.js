// Analyses: questions with their number, or with what they still need; opening one asks for just that, its answer stands beside.
import { html } from "/static/preact.min.js";
import { $, withUnit } from "/static/tools.js";
import { askJson, askText, behind, guarded } from "/static/server.js";
import { answered, at, changed, isUnitAsked, job, keep, on, state } from "/static/job.js";
import { JobField, Rows } from "/static/fields.js";
import { OwnFile, Options, fillOptions, fileOf, optionsOf } from "/static/analysis-file.js";
import { cancel, last, list, runOf, running, start, watched } from "/static/runs.js";
import { mount, signal } from "/static/store.js";
import { labelOf } from "/static/said.js";
import { inWords, t } from "/static/words.js";

const chosen = signal("");
const done = signal([]); // { verb, id, files, words, report } of each that is done, the latest first
const open = new Set();
const asking = {}; // verb → the needs that were open when it was looked at: they stay while they are typed

export function setUp() {
  mount(Questions, $("panel-analyse"));
  mount(Answer, $("answer"));
  on("selected", looked);
  on("forgotten", () => { waiting = []; });
  on("saved", behind(async () => { if (done.value.length) list((await askJson("/api/runs")).runs); })); // a number may be an earlier job's now
}
// Answers of before: asked for once somebody looks at the questions.
let waiting = [];
export function later(runs) { waiting = runs; }
export const looked = behind(async (tab) => {
  if (tab !== "analyse" || !waiting.length) return;
  const runs = waiting;
  waiting = [];
  list((await askJson("/api/runs")).runs); // a number may be an earlier job's now
  for (const told of runs) if (!answerOf(told.verb)) await show(told);
});
export const known = (verb) => state.analyses.some((each) => each.verb === verb);

export const run = guarded(async () => {
  const { verb: name, reads, options } = opened(), body = { options: optionsOf(name) };
  const missing = options.find(({ key, required }) => required && body.options[key] === undefined);
  if (missing) throw new Error(t("{name} is missing", { name: t(missing.words) }));
  if (["job", "both", "crank"].includes(reads)) {
    answered();
    body.job = job();
  }
  if (["file", "both"].includes(reads)) body.file = fileOf(name);
  const told = await watched(() => start(name, body));
  if (!told) return;
  await show(told);
  setTimeout(() => $("answer").scrollIntoView({ block: "nearest" })); // below the questions on a phone
});

// An analysis that is done, before all others; one of the same kind gives way.
export async function show({ id, verb: name, files }) {
  const [words, report] = await Promise.all([files.includes("summary.txt") ? askText(`/api/runs/${id}/files/summary.txt`) : "", askJson(`/api/runs/${id}/report`)]);
  done.value = [{ id, verb: name, files, words, report }, ...done.value.filter((each) => each.verb !== name)];
}

const opened = () => state.analyses.find((each) => each.verb === chosen.value) || state.analyses[0];
const answerOf = (name) => done.value.find((each) => each.verb === name);
const isOld = (found) => Boolean(found && runOf(found.id)?.job_changed);

// --- what is missing ------------------------------------------------------------------------------------------

const isPm = (value) => Boolean(value) && typeof value === "object" && Object.entries(value).some(([key, each]) => (/(^|_)pm(_|$)/.test(key) && each !== 0) || isPm(each));
const isGiven = (need, tables) => need.split("|").some((path) => {
  if (path === "*pm*") return isPm(tables);
  const value = path.split(".").reduce((values, name) => values?.[name], tables);
  return value !== undefined && value !== null;
});
// What the job lacks for an analysis, by the keys that it would ask for.
export function lacking({ reads, needs }) {
  if (["job", "both", "crank"].includes(reads) && (!state.file || isUnitAsked())) return ["crank"];
  const tables = job();
  return needs.filter((need) => !isGiven(need, tables)).map((need) => need.split("|")[0]);
}
const needWords = (paths) => (paths[0] === "crank" ? t(state.file ? "the unit of the file" : "a crank") : paths.slice(0, 3).map(labelOf).join(", ") + (paths.length > 3 ? " …" : ""));
// What the state line says of the question that is open.
export function line() {
  const now = opened(), lacks = lacking(now), found = answerOf(now.verb), going = running().some((each) => each.verb === now.verb);
  const needs = lacks.length ? t("needs: {what}", { what: needWords(lacks) }) : "";
  const says = needs || (isOld(found) ? t("The job has changed since then.") : found ? numberOf(now, found) : t("Nothing is cut."));
  return { tone: isOld(found) ? "stale" : "plain", words: t(now.question), says, main: { id: "analyse", words: t(found && !isOld(found) ? "Compute again" : "Compute and draw"), off: lacks.length > 0 || going, work: run } };
}

// --- the questions --------------------------------------------------------------------------------------------

function Questions() {
  const now = opened();
  if (!now) return "";
  const groups = [...new Set(state.analyses.map((each) => each.group))];
  return html`<div class="asked" data-testid="questions"><h2>${t("What else of this crank?")}</h2><p class="quiet">${t("Each uses the job as it is. What is missing is asked for when you open it.")}</p>
    ${groups.map((group) => html`<h3 key=${group}>${t(group)}</h3>${state.analyses.filter((each) => each.group === group).map((each) => html`<${Question} key=${each.verb} ...${each}/>${each === now ? html`<${Asked} key=${`asked-${each.verb}`} now=${each}/>` : ""}`)}`)}</div>`;
}

function Question(each) {
  const { verb: name, reads, says } = each, run = last(name), going = running().find((one) => one.verb === name), found = answerOf(name), lacks = lacking(each);
  const failed = run?.state === "failed" && !run.job_changed ? run : null, is = going ? "running" : lacks.length ? "needs" : found ? (isOld(found) ? "old" : "done") : failed ? "failed" : "new";
  const states = { running: () => `${Math.round(100 * going.share)} %`, old: () => `${t("earlier job")}: ${numberOf(each, found)}`, done: () => numberOf(each, found), needs: () => t("needs: {what}", { what: needWords(lacks) }), failed: () => failed.error.replace(/^job\.toml: /, ""), new: () => (reads === "records" ? t("send a file") : t("not run")) };
  return html`<button type="button" class=${`kind question${opened().verb === name ? " chosen" : ""}`} aria-expanded=${String(opened().verb === name)} data-testid=${`question-${name}`} data-is=${is} onClick=${() => { chosen.value = name; }}><b>${t(each.question)}</b><span class="says">${states[is]()}</span><small>${t(says)}</small></button>`;
}

// The one number of an answer, with its words; where it has none, that it is done.
const REDUCED = { first: (all) => all[0], last: (all) => all.at(-1), least: (all) => Math.min(...all), greatest: (all) => Math.max(...all) };
const reached = (value, [name, ...rest]) => (name === undefined ? [value] : value === null || value === undefined ? [] : name === "*" ? Object.values(value).flatMap((each) => reached(each, rest)) : reached(value[name], rest));
function numberOf({ numbers }, { report }) {
  for (const { words, path, unit, digits, of, factor } of numbers) {
    const found = reached(report, path.split(".")).filter((each) => typeof each === "number");
    if (found.length) return `${withUnit(factor * REDUCED[of](found), digits, unit)} ${t(words)}`;
  }
  return t("done");
}

// What one question asks: what is missing first, its own file or options, and all that it reads, folded.
function Asked({ now }) {
  const { verb: name, reads, given } = now, was = (asking[name] ||= []), lacks = lacking(now);
  for (const path of lacks) if (path !== "crank" && !was.includes(path)) was.push(path);
  fillOptions(name, Object.fromEntries(Object.entries(given).map(([key, path]) => [key, path.startsWith("crank.") ? state.inspected?.report.crank[path.slice(6)] : at(path)])));
  return html`<div class="asks" id="asks" data-verb=${name}>
    ${was.length ? html`<div class="fields wide" data-testid="missing">${was.map((path) => html`<${Needed} key=${path} path=${path}/>`)}</div>` : ""}
    ${now.tables.length ? html`<${OwnFile} key=${`file-${name}`} verb=${name} tables=${now.tables}/>` : ""}
    ${["records", "options"].includes(reads) ? html`<${Options} key=${`options-${name}`} verb=${name} fields=${now.options}/>` : ""}
    ${reads === "job" || (now.options.length && !["records", "options"].includes(reads)) ? html`<details class="fold" key=${`more-${name}`} open=${open.has(`more-${name}`)} ontoggle=${toggled(`more-${name}`)}><summary>${t("More values that it reads")}</summary>${reads === "job" ? html`<${Read} key=${name} by=${name}/>` : ""}${["records", "options"].includes(reads) ? "" : html`<${Options} key=${`options-${name}`} verb=${name} fields=${now.options}/>`}</details>` : ""}
    <${Going}/></div>`;
}
const toggled = (name) => ({ target }) => { if (target.open) open.add(name); else open.delete(name); };
function Needed({ path }) {
  const [table, ...rest] = path.split("."), key = rest.join("."), field = state.declared.tables.find((each) => each.table === table)?.keys.find((each) => each.key === key);
  return field ? html`<${JobField} id=${`need-${path.replaceAll(".", "-")}`} table=${table} field=${field}/>` : "";
}

// What is being computed, how far it is, and a button to end it.
function Going() {
  return running().filter((told) => known(told.verb)).map((told) => html`<div class="going" key=${told.id} data-testid="going"><progress max="1" value=${told.share} aria-label=${told.verb}></progress><span>${told.verb}: ${told.words}</span> <button type="button" aria-label=${`${t("Cancel")} ${told.verb}`} onClick=${guarded(() => cancel(told.id))}>${t("Cancel")}</button></div>`);
}

// The keys of the job that one analysis reads and not every one: as fields.
function Read({ by }) {
  const tables = state.declared.tables, own = tables.filter((each) => each.verbs.includes(by));
  const loose = tables.filter((each) => !own.includes(each) && !each.many).flatMap(({ table, keys }) => keys.filter((key) => key.verbs.includes(by)).map((field) => ({ table, field })));
  return html`<div id="analysis-reads">${loose.length ? html`<div class="fields wide">${loose.map(({ table, field }) => html`<${Single} by=${by} table=${table} field=${field}/>`)}</div>` : ""}
    ${own.map(({ table, says, many, keys }) => html`<details key=${table} open=${open.has(table)} ontoggle=${toggled(table)}><summary>${inWords(table)} <small>${inWords(t(says))}</small></summary>
      ${many ? html`<${Rows} id=${`${by}-${table}`} field=${{ words: table, says, fields: keys }} now=${at(table)} set=${(value) => { keep(table, value); changed(); }}/>` : html`<div class="fields wide">${keys.map((field) => html`<${Single} by=${by} table=${table} field=${field}/>`)}</div>`}</details>`)}</div>`;
}
const Single = ({ by, table, field }) => html`<${JobField} key=${field.key} id=${`${by}-${table}-${field.key.replaceAll(".", "-")}`} table=${table} field=${field}/>`;

// --- the answer -----------------------------------------------------------------------------------------------

function Answer() {
  const now = opened(), found = now && answerOf(now.verb), isShown = Boolean(found) && document.body.dataset.tab === "analyse";
  $("answer").hidden = !isShown;
  document.body.dataset.answer = String(isShown);
  return isShown ? html`<${Done} key=${found.id} now=${now} ...${found}/>` : "";
}

function Done({ now, id, verb: name, files, words, report }) {
  const url = (file) => `/api/runs/${id}/files/${encodeURIComponent(file)}`, isEarlier = isOld({ id });
  const pictures = files.filter((file) => /\.(svg|png)$/.test(file)), others = files.filter((file) => !pictures.includes(file));
  return html`<section id=${`analysis-${name}`} data-old=${String(isEarlier)}><h2>${t(now.question)}</h2><p class="lead">${isEarlier ? html`<span class="badge" data-tone="stale">${t("earlier job")}</span> ` : ""}<b>${numberOf(now, { report })}</b></p>
    ${pictures.length ? html`<div class="plots">${pictures.map((file) => html`<figure key=${file} class="card"><figcaption>${file.replace(/\.\w+$/, "").replaceAll("-", " ")}</figcaption><a href=${url(file)} target="_blank"><img src=${url(file)} alt=${file.replace(/\.\w+$/, "").replaceAll("-", " ")} loading="lazy"/></a></figure>`)}</div>` : html`<p class="quiet">${t("There is nothing to draw.")}</p>`}
    ${words ? html`<pre tabindex="0" aria-label=${t("Summary of {verb}", { verb: name })}>${words}</pre>` : ""}
    <p class="buttons">${others.map((file) => html`<a href=${url(file)} download=${file}>${file}</a> `)}</p></section>`;
}
