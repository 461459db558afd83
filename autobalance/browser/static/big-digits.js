// Digits to be read from three metres, and keys for fingers: what is read, then each of the cuts, ticked when it is done.
import { html, useEffect, useRef, useState } from "/static/preact.min.js";
import { emit, on, state } from "/static/job.js";
import { shown } from "/static/tools.js";
import { askJson, behind, guarded } from "/static/server.js";
import { Heavy, Plane, big, missing, read, recut } from "/static/machine.js";
import { nounOf } from "/static/kind-cards.js";
import { doneAt, enteredFrom, isAdded } from "/static/cuts.js";
import { redraw } from "/static/store.js";
import { angleText, sign, zeroWords } from "/static/zero.js";
import { unitOf } from "/static/units.js";
import { t } from "/static/words.js";

const ADDRESS = "#big", FOLLOWS_MS = 3000;
const isOwn = () => location.hash === ADDRESS; // a window at this address shows nothing else
export const onItsOwn = () => open(`/${ADDRESS}`); // it has this tab's token, and may tick
const channel = new BroadcastChannel("autobalance-ticks");

export function setUp() {
  on("result", behind(async () => { state.ticks = {}; await follow(); if (isOwn()) { emit("tab", "machine"); big.value = true; } }));
  channel.onmessage = () => follow();
  setInterval(() => { if (big.value) follow(); }, FOLLOWS_MS);
}

// What was ticked elsewhere is ticked here; a window of its own goes on to the next stage.
const follow = behind(async () => {
  const id = state.result?.id;
  if (!id) return;
  const found = await askJson(`/api/runs/${id}/ticks`);
  if (state.result?.id !== id) return;
  taken(found);
  if (isOwn() && found.latest !== id) emit("show", await askJson(`/api/runs/${found.latest}`));
});
function taken({ ticks }) {
  state.ticks = ticks;
  redraw();
}
const tick = guarded(async (number, done) => {
  taken(await askJson(`/api/runs/${state.result.id}/ticks`, { method: "PUT", body: JSON.stringify({ number, done }) }));
  channel.postMessage(number);
});
export const cutsDone = (cuts) => cuts.filter(({ number }) => state.ticks[number]).length;

const NEXT = -1; // the first cut that is not done
export function BigDigits() {
  const box = useRef(null), [page, setPage] = useState(isOwn() ? NEXT : 0);
  useEffect(() => { if (big.value && !box.current.open) box.current.showModal(); if (!big.value && box.current.open) box.current.close(); });
  const cuts = state.result.report.corrections, open = cuts.findIndex(({ number }) => !state.ticks[number]);
  const at = page === NEXT ? (open < 0 ? cuts.length : open + 1) : Math.min(page, cuts.length), cut = cuts[at - 1], places = read.planes === "2" ? [1, 2] : [1];
  const close = () => { big.value = false; if (isOwn()) window.history.replaceState(null, "", "/"); };
  const key = (words, work, more = {}) => html`<button type="button" ...${more} onClick=${work}>${t(words)}</button>`;
  const isDone = cut && state.ticks[cut.number];
  return html`<dialog id="big-digits" data-testid="big-digits" data-own=${String(isOwn())} ref=${box} aria-label=${t("Big digits")} onClose=${close}>${!big.value ? "" : html`
    ${at === 0 ? html`<div class="big-planes">${places.map((place) => html`<div><${Plane} place=${place} before="big-"/><${Heavy} place=${place}/></div>`)}</div>` : html`<${Cut} cut=${cut} count=${cuts.length} place=${at}/>`}
    <p class="buttons">${key("Back", () => setPage(at - 1), { hidden: at === 0 })}${at === 0 ? key("The cuts", () => setPage(NEXT), { disabled: !cuts.length }) : isDone ? key("Next", () => setPage(at + 1), { disabled: at >= cuts.length }) : key(at < cuts.length ? "Done, next cut" : "Done, last cut", async () => { await tick(cut.number, true); setPage(NEXT); }, { class: "main", "data-testid": "cut-done" })}
    ${at === 0 ? key("Plan the next cuts", () => recut(false), { class: "main", disabled: Object.keys(missing()).length > 0 }) : ""}${isDone ? key("Not done", () => { tick(cut.number, false); setPage(at); }, { "data-testid": "cut-not-done" }) : key("Close", close)}</p>`}</dialog>`;
}

function Cut({ cut, count, place }) {
  const figures = [[t("angle"), html`${angleText(cut.angle_deg)}<small class="ref"> ${sign()}</small>`], [isAdded(cut) ? t("height") : t("depth"), `${shown(Math.abs(cut.depth_mm), 2, "mm")} ${unitOf("mm")}`], ["⌀", cut.diameter_mm ? `${shown(cut.diameter_mm, 2, "mm")} ${unitOf("mm")}` : "–"], ["z", `${shown(cut.z_mm, 1, "mm")} ${unitOf("mm")}`]];
  return html`<div class="big-cut" data-cut=${String(cut.number)}><p>${t("Cut {number}, {place} of {count}", { number: cut.number, place, count })}: ${nounOf(cut.kind)}, ${t("web")} ${cut.web ?? "–"}, ${enteredFrom(cut)}${state.ticks[cut.number] ? html` <strong data-tone="good">${doneAt(cut)}</strong>` : ""}</p><dl>${figures.map(([name, value]) => html`<dt>${name}</dt><dd>${value}</dd>`)}</dl><p>${zeroWords()}</p></div>`;
}
