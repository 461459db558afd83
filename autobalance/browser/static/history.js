// History: cranks with their results; any two side by side.
import { html } from "/static/preact.min.js";
import { $, shown } from "/static/tools.js";
import { askJson, behind, guarded, post } from "/static/server.js";
import { brought, changed, crankName, emit, on, state } from "/static/job.js";
import { nameOf, results, takeAway } from "/static/runs.js";
import { Scaled, open } from "/static/open.js";
import { mount, redraw, signal } from "/static/store.js";
import { judgedAt, judgement } from "/static/verdict.js";
import { kindWords, manyWords } from "/static/kind-cards.js";
import { unitOf } from "/static/units.js";
import { locale, t } from "/static/words.js";

const reports = new Map(); // id → report
const ticked = signal([]); // ids of at most two, the latest last

export function setUp() {
  mount(History, $("panel-history"));
  on("selected", behind(async (tab) => {
    if (tab !== "history") return;
    for (const told of results()) await known(told);
  }));
}

// The report of a result, asked for once.
export async function known({ id }) {
  if (reports.has(id)) return;
  reports.set(id, await askJson(`/api/runs/${id}/report`));
  redraw();
}
export const reportOf = (id) => reports.get(id);

function History() {
  const runs = results(), cranks = [...new Set([...runs.map(({ crank }) => crank || ""), ...(state.file ? [state.file] : []), ...Object.keys(state.cranks)])];
  const current = cranks.includes(state.file) ? [state.file, ...cranks.filter((each) => each !== state.file)] : cranks;
  return html`<div class="history"><div><h2>${t("Cranks and results")}</h2><p class="quiet">${runs.length ? t("Every result keeps its job, its papers and its time. Tick two to compare.") : t("No result yet")}</p>${current.map((crank) => html`<${Crank} key=${crank} crank=${crank} runs=${runs.filter((told) => (told.crank || "") === crank)}/>`)}</div><${Two} runs=${runs}/></div>`;
}

// A second job beside the first: the same crank by another name, its job as it is now.
const duplicate = guarded(async () => {
  await brought(() => post("/api/duplicate", {}), true);
  state.cranks = (await askJson("/api/cranks")).cranks;
  changed();
  await open();
});
// Open a crank of before, with its job as it was.
export const again = (crank) => guarded(async () => {
  if (crank !== state.file) {
    await brought(() => post("/api/open", { file: crank }), true);
    changed();
    state.cranks = (await askJson("/api/cranks")).cranks;
    await open();
  }
  emit("tab", "open");
});
function Crank({ crank, runs }) {
  const isOpen = crank === state.file;
  return html`<section class="of-crank" data-testid="history-crank" data-crank=${crank}><div class="top"><h3>${crankName(crank) || t("From elsewhere")} ${isOpen ? html`<span class="badge" data-tone="plain">${t("open now")}</span>` : ""}</h3>${!crank ? "" : isOpen ? html`<button type="button" class="small" data-testid="duplicate" onClick=${duplicate}>${t("Duplicate")}</button>` : html`<button type="button" class="small" onClick=${again(crank)}>${t("Open")}</button>`}</div><${Scaled} file=${crank}/>
    ${runs.length ? "" : html`<p class="quiet">${t("No result yet")}</p>`}<table hidden=${!runs.length}><thead><tr><td></td><th scope="col">${t("result")}</th><th scope="col">${t("left of permitted")}</th><td></td><th scope="col">${t("made")}</th><td></td></tr></thead><tbody>${runs.map((told) => html`<${Result} key=${told.id} told=${told}/>`)}</tbody></table></section>`;
}

export function cutsOf(report) {
  const kinds = [...new Set((report?.corrections || []).map(({ kind }) => kind))];
  return kinds.length ? `${kinds.map(kindWords).join(" + ")}, ${manyWords(kinds.length === 1 ? kinds[0] : "", report.corrections.length)}` : t("nothing cut");
}
function leftOf(report) {
  const [place, found, limit] = judgedAt(report);
  return `${found === report.residual ? "" : `${place}: `}${shown(found.magnitude_g_mm, 2, "g·mm")} ${t("of {limit}", { limit: `${shown(limit, 2, "g·mm")} ${unitOf("g·mm")}` })}`;
}
export const when = (told) => new Date(told.started).toLocaleString(locale, { dateStyle: "short", timeStyle: "short" });

function Result({ told }) {
  const { id } = told, report = reports.get(id), found = report && judgement(report, told);
  const tick = ({ target }) => { ticked.value = [...ticked.value.filter((each) => each !== id), ...(target.checked ? [id] : [])].slice(-2); };
  const isTicked = ticked.value.includes(id), name = report ? cutsOf(report) : nameOf(told);
  return html`<tr data-run=${id} data-ticked=${String(isTicked)}><td><input type="checkbox" aria-label=${t("Compare {name}", { name: `${name}, ${when(told)}` })} checked=${isTicked} onChange=${tick}/></td>
    <td><button type="button" class="link" onClick=${() => { emit("show", told); emit("tab", "see"); }}>${told.verb === "recut" ? `${t("Reading")}: ` : ""}${name}</button></td><td class="num">${report ? leftOf(report) : "…"}</td><td>${found ? html`<span class="badge" data-tone=${found.tone}>${found.words}</span>` : ""}</td><td class="num">${when(told)}</td><td><button type="button" class="bare" aria-label=${`${t("Delete")} ${name}, ${when(told)}`} onClick=${() => takeAway(told)}>×</button></td></tr>`;
}

// Any two results side by side; bold is the better one where better has a meaning.
const sum = (report, key) => report.corrections.reduce((all, each) => all + (each[key] || 0), 0);
const LINES = [
  ["Left", (report) => report.residual.magnitude_g_mm, "g·mm", 2, true], ["Uncertainty", (report) => report.residual.uncertainty_g_mm, "g·mm", 2, true], ["Permitted", (report) => report.tolerance.permissible_g_mm, "g·mm", 2, false], ["Cuts", (report) => report.corrections.length, "", 0, true],
  ["Metal off", (report) => sum(report, "removed_mass_g"), "g", 1, true], ["Deepest cut", (report) => Math.max(0, ...report.corrections.map(({ depth_mm: depth }) => Math.abs(depth))), "mm", 2, false], ["Change of inertia", (report) => report.inertia_change_kg_mm2, "kg·mm²", 1, false], ["Factor", (report) => report.balance_factor.final, "", 3, false], ["Bob-weight", (report) => report.engine.bob_weights[0]?.mass_g, "g", 2, false],
];
function Two({ runs }) {
  const both = ticked.value.map((id) => runs.find((told) => told.id === id)).filter((told) => told && reports.has(told.id));
  if (both.length < 2) return "";
  const [one, other] = both.map(({ id }) => reports.get(id));
  const line = ([words, value, unit, digits, isLess]) => {
    const values = [value(one), value(other)], isKnown = values.every((each) => typeof each === "number"), best = isLess && isKnown && Math.abs(values[0] - values[1]) > 1e-9 ? values.indexOf(Math.min(...values)) : -1;
    return html`<tr><th scope="row">${t(words)}${unit ? ` [${unitOf(unit)}]` : ""}</th>${values.map((each, k) => html`<td class="num" data-value=${String(each)}>${k === best ? html`<b>${shown(each, digits, unit)}</b>` : shown(each, digits, unit)}</td>`)}</tr>`;
  };
  return html`<aside class="of-crank" data-testid="compare-two" aria-label=${t("Compare two")}><h3>${t("Compare two")}</h3><table><thead><tr><td></td>${both.map((told) => html`<th scope="col">${crankName(told.crank)}<br/>${cutsOf(reports.get(told.id))}<br/><small>${when(told)}</small></th>`)}</tr></thead><tbody>${LINES.map(line)}</tbody></table><p class="quiet">${t("Bold is the better one where better has a meaning.")}</p></aside>`;
}
