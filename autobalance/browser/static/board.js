// Alternatives: every kind of correction and the useful mixes on this crank, as cards with pictures, the best first.
import { html } from "/static/preact.min.js";
import { $, withUnit } from "/static/tools.js";
import { askJson, behind, guarded } from "/static/server.js";
import { answered, applied, changed, job, on, state } from "/static/job.js";
import { chosen, kinds, listed, ofAllKinds, tableOf } from "/static/limits.js";
import { cutting, running, start, watched } from "/static/runs.js";
import { Measured } from "/static/measured.js";
import { signal } from "/static/store.js";
import { said } from "/static/said.js";
import { kindWords } from "/static/kind-cards.js";
import { decimal, plain, t } from "/static/words.js";

const VERDICTS = { within_tolerance: "within tolerance", already_within_tolerance: "already within tolerance", above_tolerance: "above tolerance" };
const shown = signal(null); // { id, of, rows, pictures, recommended, why, whole }
const asking = signal(""); // a card that fails, and that somebody is about to take all the same

export function setUp() {
  on("forgotten", () => { shown.value = waiting = null; });
  on("selected", looked);
}
// A comparison of before: asked for once somebody looks at the kinds.
let waiting = null;
export const later = (told) => { waiting = told || null; };
export const looked = behind(async (tab) => {
  const told = waiting;
  if (tab !== "correct" || !told) return;
  waiting = null;
  if (!shown.value) await board(told);
});
export const compare = guarded(async () => {
  answered();
  let seen = 0;
  const asked = job(true), of = { ...asked, correction: ofAllKinds(asked.correction) };
  const meanwhile = async (told) => {
    const found = await askJson(`/api/runs/${told.id}/cards`).catch(() => null);
    if (found && found.rows.length + found.pictures.length > seen && !shown.value?.whole) { seen = found.rows.length + found.pictures.length; shown.value = { id: told.id, of, ...found, whole: false }; }
  };
  shown.value = null;
  choosing.value = true;
  try {
    const told = await watched(() => start("compare", { job: of }, "", meanwhile));
    if (told) await board(told);
    if (told && !cutting() && JSON.stringify(job(true)) === JSON.stringify(asked)) recommended(); // of the job as it is
  } finally { choosing.value = false; }
});
const choosing = signal(false);
// Whether a comparison runs, or is about to choose what it recommends.
export const isComparing = () => choosing.value || running().some((each) => each.verb === "compare");
// What the comparison recommends is chosen; another card, or a step back, takes what one likes better.
function recommended() {
  const names = shown.value?.recommended?.split("+") || [];
  if (!names.length || listed.cuts || !names.every(kinds.of)) return;
  const [method, also = "", ...others] = names;
  Object.assign(chosen, { method, also, others });
  changed();
}

export async function board(told) {
  const of = (await askJson(`/api/runs/${told.id}/asked`)).job, report = await askJson(`/api/runs/${told.id}/report`);
  const pictures = told.files.filter((name) => name.endsWith(".png")).map((name) => name.replace(/\.png$/, ""));
  shown.value = { id: told.id, of, rows: report.rows, pictures, recommended: report.recommended?.join("+"), why: report.why, prefer: report.prefer, ranking: report.ranking, unbeaten: report.unbeaten, whole: true };
}

// What an alternative depends on: all of a job but which of them is chosen, and the limits of its kinds.
function asks({ correction = {}, ...job }, methods, tables) {
  const own = Object.fromEntries(methods.map((name) => [name, tables(name)])), left = Object.fromEntries(Object.entries(correction).filter(([key]) => !["method", "cut", "keep"].includes(key) && !kinds.of(key)));
  return JSON.stringify({ ...job, left, own }, (_, value) => (value && typeof value === "object" && !Array.isArray(value) ? Object.fromEntries(Object.entries(value).sort(([a], [b]) => (a < b ? -1 : 1))) : value));
}
// The alternative of one method, or mix, as it was compared last; old: of an earlier job.
export function compared(methods) {
  const name = methods.join("+"), place = shown.value?.rows.findIndex((row) => nameOf(row) === name) ?? -1;
  if (place < 0) return null;
  return { row: shown.value.rows[place], place, isBest: shown.value.recommended === name, isOld: asks(shown.value.of, methods, (kind) => shown.value.of.correction?.[kind] || {}) !== asks(job(true), methods, tableOf), hasPicture: shown.value.pictures.includes(name) };
}
export const hasCompared = () => Boolean(shown.value);
// The picture of an alternative over the view; none: gone.
export function pictured(name) {
  const url = name && shown.value?.pictures.includes(name) ? `/api/runs/${shown.value.id}/cards/${encodeURIComponent(`${name}.png`)}` : "";
  $("big-picture").hidden = !url;
  $("big-picture").replaceChildren(...(url ? [Object.assign(new Image(), { src: url, alt: "" })] : []));
}

const nameOf = (row) => row.method.join("+");
const good = (row) => row.outcome === "within_tolerance" || row.outcome === "already_within_tolerance";
// Two rows that make the same cuts are one plan; the one with fewer kinds stands for both.
const plan = (row) => JSON.stringify([row.outcome, row.residual_g_mm, row.metal_moved_g, row.cuts, row.inertia_change_kg_mm2]);

export function Board() {
  return html`<div id="board" data-testid="board" role="group" aria-label=${t("Alternatives")}><${Cards}/></div>`;
}
// The sentence that says why one is recommended: the program's, in the page's language and units.
export const Why = () => (shown.value?.why && shown.value.ranking ? html`<p class="quiet" id="board-why">${why(shown.value)}</p>` : "");
const ORDER = { simple: "fewest different cuts, then fewest cuts, then the least metal", same_setup: "fewest different cuts, then fewest cuts, then the least metal", least_metal: "least metal", fewest_holes: "fewest cuts, then the least metal", least_inertia_change: "least change of inertia", most_inertia_removed: "most inertia removed" };
const named = (row) => row.method.map(kindWords).join(" + ");
function why({ rows, ranking, prefer, why: told }) {
  const [first, next] = ranking.map((name) => rows.find((row) => nameOf(row) === name));
  if (!first) {
    const near = rows.filter((row) => row.residual_share !== null).sort((one, other) => one.residual_share - other.residual_share)[0];
    return near ? t("none is within tolerance; {name} comes nearest, to {share} times the permissible unbalance", { name: named(near), share: plain(Number(near.residual_share.toPrecision(3))) }) : t("no kind of correction has a place on this crank");
  }
  if (first.outcome === "already_within_tolerance") return t("the crank is within tolerance; no cut is needed");
  const parts = [t("{name}: {figures}; ranked by {order}", { name: named(first), figures: figures(first), order: t(ORDER[prefer]) }) + (told.includes("metal taken off before") ? `, ${t("metal taken off before metal added")}` : "")];
  if (next) parts.push(t("next is {name}: {figures}", { name: named(next), figures: figures(next) }));
  return parts.join("; ");
}
function figures({ cuts, different_cuts: different, metal_moved_g: moved, wall_left_mm: wall, web_metal_share: share }) {
  const found = [cuts === 1 ? t("1 cut, {different} different", { different }) : t("{count} cuts, {different} different", { count: cuts, different }), t("{mass} moved", { mass: withUnit(moved || 0, 1, "g") })];
  if (wall !== null && wall !== undefined) found.push(t("{wall} of wall left", { wall: withUnit(wall, 1, "mm") }));
  if (share !== null && share !== undefined) found.push(t("{share} % of webs' metal kept", { share: decimal(100 * share, 0) }));
  return found.join(", ");
}
function Cards() {
  if (!shown.value) return null;
  const { rows, recommended, whole } = shown.value, first = new Map();
  rows.forEach((row, place) => { if (row.outcome && !first.has(plan(row))) first.set(plan(row), { row, place, also: [] }); else if (row.outcome) first.get(plan(row)).also.push(nameOf(row)); });
  const none = rows.flatMap((row, place) => (row.outcome ? [] : [{ row, place, also: [] }]));
  const rank = ({ row }) => (nameOf(row) === recommended ? 0 : row.rank ?? 1e6);
  const cards = [...[...first.values()].sort((a, b) => rank(a) - rank(b)), ...none];
  return html`${whole ? "" : html`<p class="quiet" role="status">${t("More to come …")}</p>`}${cards.map((each) => html`<${Card} key=${nameOf(each.row)} ...${each}/>`)}`;
}

function Card({ row, place, also }) {
  const { id, pictures, recommended, unbeaten = [] } = shown.value, name = nameOf(row), url = `/api/runs/${id}/cards/${encodeURIComponent(`${name}.png`)}`, best = name === recommended, has = pictures.includes(name);
  const facts = [["Residual", "residual_g_mm"], ["Metal moved", "metal_moved_g"], ["Inertia", "inertia_change_kg_mm2"], ["Cuts", "cuts"], ["Wall left", "wall_left_mm"]];
  const grams = (key, value) => (key === "metal_moved_g" && value !== null ? " g" : "");
  const big = (now) => pictured(now ? name : "");
  const take = () => { if (good(row) || asking.value === name) { asking.value = ""; applied({ "correction.method": row.method }); } else asking.value = name; };
  return html`<article class=${best ? "card best" : "card"} aria-label=${name} onMouseEnter=${() => has && big(true)} onMouseLeave=${() => big(false)} onFocusIn=${() => has && big(true)} onFocusOut=${() => big(false)}><h3>${name}</h3>
    ${best ? html`<p class="tile-note">${t("Recommended")}</p>` : ""}${has ? html`<img src=${url} alt=${t("The crank corrected by {name}", { name })} loading="lazy"/>` : ""}
    <p>${t(row.outcome ? VERDICTS[row.outcome] : "no place on this crank")}</p>${unbeaten.includes(name) ? html`<p class="quiet">${t("no better alternative")}</p>` : row.beaten_by?.length ? html`<p class="quiet">${t("better alternative: {names}", { names: row.beaten_by.join(", ") })}</p>` : ""}
    ${also.length ? html`<p class="quiet">${t("the same plan as {names}", { names: also.join(", ") })}</p>` : ""}${row.reason ? html`<p class="quiet">${said(row.reason)}</p>` : ""}
    ${row.outcome ? html`<dl>${facts.map(([words, key]) => html`<dt>${t(words)}</dt><dd><${Measured} of=${`rows.${place}.${key}`} value=${row[key]} digits=${key === "cuts" ? 0 : 2} named/>${grams(key, row[key])}</dd>`)}</dl>
    ${asking.value === name ? html`<p role="alert">${t("The crank stays above tolerance. Use this plan anyway?")}</p>` : ""}<button type="button" aria-label=${t("Use {name}", { name })} onClick=${take}>${asking.value === name ? t("Use it anyway") : t("Use this one")}</button>` : ""}</article>`;
}
