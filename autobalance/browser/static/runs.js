// Runs: several at once, each followed to its end; a page that comes back finds them.
import { html } from "/static/preact.min.js";
import { askJson, guarded, post, remove, say } from "/static/server.js";
import { crankName, emit, state } from "/static/job.js";
import { signal } from "/static/store.js";
import { STAYS_MS, toast } from "/static/toast.js";
import { said } from "/static/said.js";
import { locale, t } from "/static/words.js";

const ENDED = ["done", "failed", "cancelled"];
const following = new Map(); // id → { resolve, reject }
let polling = false;
let newest = null;
const words = {}; // id → what it is of, for people

export async function start(verb, body, name = "", meanwhile = null) {
  const { id } = await post("/api/runs", { verb, ...body });
  words[id] = name;
  return follow(id, verb, meanwhile);
}

// Resolve with what is told of a run once it is done; null when it was cancelled. `meanwhile` is told how far it is.
export function follow(id, verb, meanwhile = null) {
  if (verb !== "inspect") newest = id;
  const end = new Promise((resolve, reject) => following.set(id, { resolve, reject, meanwhile }));
  poll();
  return end;
}

async function poll() {
  if (polling) return;
  polling = true;
  try {
    while (following.size) {
      const { runs } = await askJson("/api/runs");
      list(runs);
      for (const told of runs) {
        const end = following.get(told.id);
        if (!end) continue;
        if (!ENDED.includes(told.state)) { end.meanwhile?.(told); continue; }
        following.delete(told.id);
        if (told.state === "failed") end.reject(Object.assign(new Error(told.error), { run: told.id }));
        else end.resolve(told.state === "done" ? told : null);
      }
      if (following.size) await new Promise((resolve) => setTimeout(resolve, 120));
    }
  } catch (error) {
    for (const end of following.values()) end.reject(error);
    following.clear();
  } finally {
    polling = false;
    list((await askJson("/api/runs").catch(() => ({ runs: [] }))).runs);
  }
}

let heard = ""; // what was listed last: while a run goes on the same comes again and again, and nothing is drawn for it
export function list(runs) {
  const news = JSON.stringify([newest, runs]);
  if (news === heard) return;
  heard = news;
  const going = runs.filter((each) => !ENDED.includes(each.state));
  const shown = going.find((each) => each.id === newest) || going[going.length - 1];
  const last = shown || runs.find((each) => each.id === newest) || runs.findLast((each) => each.verb !== "inspect") || runs.at(-1);
  now.value = { going: shown ? shown.id : "", last: last || null }; // a page that comes after the end of a run shows that end
  listed.value = runs.filter((each) => each.verb !== "inspect" || !ENDED.includes(each.state)).reverse();
}

// How far a run is, in the reader's words.
export function doing(words) {
  const pass = words.match(/^cutting, pass (\d+)$/);
  return pass ? t("cutting, pass {number}", { number: pass[1] }) : t(words);
}
const now = signal({ going: "", last: null }); // the run that a person watches: its id while it goes, and how far the last one came

export function Cancel({ id = "cancel" }) {
  const { going } = now.value;
  return html`<button type="button" data-testid=${id} id=${id} disabled=${!going} data-run=${going} onClick=${guarded(async () => { if (going) await cancel(going); })}>${t("Cancel")}</button>`;
}
export function Progress() {
  const { last } = now.value, share = Math.round(100 * (last?.share || 0)), words = last ? doing(last.words) : "";
  return html`<div data-testid="progress" id="progress" role="progressbar" aria-label=${t("Progress")} aria-valuemin="0" aria-valuemax="100" aria-valuenow=${String(share)} aria-valuetext=${words} hidden=${!now.value.going}><i style=${{ width: `${share}%` }}></i><span>${words}</span></div>`;
}

const listed = signal([]);
const all = signal(false);
const FEW = 5;
// The run that cuts, or plans cuts, while it goes.
export const cutting = () => listed.value.find((each) => ["balance", "recut"].includes(each.verb) && !ENDED.includes(each.state)) || null;
// The last run of a verb, and a run by its id, as the server told of them last; null where there is none.
export const last = (verb) => listed.value.find((each) => each.verb === verb) || null;
export const runOf = (id) => listed.value.find((each) => each.id === id) || null;
// Those that wait or run, as components show them.
export const running = () => listed.value.filter((each) => !ENDED.includes(each.state));

// The runs of the project, the latest first: shown, cancelled, taken away.
export function RunList() {
  const runs = listed.value.filter(({ id }) => !leaving.value.has(id)), some = all.value ? runs : runs.slice(0, FEW);
  const more = runs.length > FEW && html`<li><button type="button" onClick=${() => { all.value = !all.value; }}>${all.value ? t("Only the latest") : t("All {count} runs", { count: runs.length })}</button></li>`;
  return html`<ul id="run-list" class="quiet" data-testid="runs" aria-label=${t("Runs")}>${some.map((told) => html`<${Item} key=${told.id} told=${told}/>`)}${more}</ul>`;
}

function Item({ told }) {
  const { id, verb } = told, done = told.state === "done" && ["balance", "recut"].includes(verb);
  const how = told.state === "running" ? `${doing(told.words)}, ${Math.round(100 * told.share)} %` : t(told.state);
  const button = (words, work) => html`<button type="button" aria-label=${`${t(words)} ${verb} ${id}`} onClick=${work}>${t(words)}</button>`;
  return html`<li data-run=${id} data-state=${told.state} aria-current=${state.result?.id === id ? "true" : undefined}><span><b>${crankName(told.crank)}</b> ${verb}${words[id] ? ` ${words[id]}` : ""}: ${how}${told.state === "done" ? html` <small>${new Date(told.started).toLocaleString(locale, { dateStyle: "short", timeStyle: "short" })}</small>` : ""}${told.error ? ` – ${said(told.error)}` : ""}</span>
    <span class="buttons">${done ? button("Show", () => { emit("show", told); emit("tab", "see"); }) : ""}${ENDED.includes(told.state) ? button("Delete", () => taken(told)) : button("Cancel", guarded(() => cancel(id)))}</span></li>`;
}

// Take a run away; what is shown of it goes with it. For some seconds it can be had back: its files go then.
const leaving = signal(new Set());
function taken(told) {
  const { id } = told, back = () => { clearTimeout(going); leaving.value = new Set([...leaving.value].filter((each) => each !== id)); };
  leaving.value = new Set([...leaving.value, id]);
  if (state.result?.id === id) emit("gone");
  const going = setTimeout(guarded(async () => { list((await remove(`/api/runs/${id}`)).runs); back(); }), STAYS_MS);
  toast(t("Deleted: {name}", { name: nameOf(told) }), { words: t("Undo"), work: back });
}
export const takeAway = taken;
export const nameOf = ({ id, verb, crank }) => [crankName(crank), verb, words[id]].filter((each) => each).join(" ");
// The results of the project, the latest first.
export const results = () => listed.value.filter((told) => told.state === "done" && ["balance", "recut"].includes(told.verb) && !leaving.value.has(told.id));
export const isHidden = (id) => leaving.value.has(id);

export const cancel = (id) => post(`/api/runs/${id}/cancel`, {});

// Follow a run for a person; what goes wrong is said.
export async function watched(work) {
  try { return await work(); } catch (error) { say(error.message); return null; }
}
