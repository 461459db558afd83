// The start: what the program does, three ways in, and the cranks and results of before.
import { html } from "/static/preact.min.js";
import { $, withUnit } from "/static/tools.js";
import { behind } from "/static/server.js";
import { CRANKS, JOBS, crankName, emit, on, state, unitOfFile } from "/static/job.js";
import { coming, dropped, example, over, sent } from "/static/files.js";
import { again, cutsOf, known, reportOf, when } from "/static/history.js";
import { results } from "/static/runs.js";
import { mount, signal } from "/static/store.js";
import { long } from "/static/open.js";
import { judgement } from "/static/verdict.js";
import { t } from "/static/words.js";

const MOST_RECENT = 4;
const isAsked = signal(false); // whether somebody went back to the start though a crank is open
export const isStart = () => (isAsked.value || !state.file) && !coming.value && document.body.dataset.tab === "open";

export function setUp() {
  mount(Mark, $("mark"));
  for (const name of ["selected", "taken", "forgotten"]) on(name, () => { isAsked.value = false; });
}
const toStart = () => {
  emit("tab", "open");
  isAsked.value = true;
  $("panels").scrollTop = 0;
  looked();
};
// Reports of the latest results, from which their rows are made.
const looked = behind(async () => { for (const told of results().slice(0, MOST_RECENT)) await known(told); });

const Mark = () => html`<button type="button" class="bare" data-testid="to-start" aria-label=${t("Start")} title=${t("Start")} onClick=${toStart}><svg viewBox="0 0 32 32" aria-hidden="true"><circle cx="16" cy="16" r="14.5" fill="none" stroke="currentColor" stroke-width="2"/><path d="M16 16 3.2 22.5A14.5 14.5 0 0 0 28.8 22.5z" fill="#d9501c"/><circle cx="16" cy="9" r="3" fill="#4fb8a9"/><circle cx="16" cy="16" r="3" fill="#7aa9d6"/></svg></button>`;

// --- the screen -----------------------------------------------------------------------------------------------

export const Start = () => html`<div class="first"><div class="hero"><div><h2>${t("Balance a crankshaft from its solid model")}</h2><p>${t("Open the model and enter what the parts weigh. autobalance plans the cuts, makes them in the solid and measures what is left, until ISO 21940-11 is met. You get the corrected solid, a shop sheet and a certificate. Your file stays on this computer.")}</p></div><${Turning}/></div><${Ways}/><${Recent}/></div>`;
// A crank that turns, seen from its end.
const Turning = () => html`<svg viewBox="0 0 120 120" role="img" aria-label=${t("A crankshaft that turns, seen from its end")}><g class="turning"><path class="c" d="M24 60A36 36 0 0 0 96 60L80 56H40Z"/><path class="w" d="M44 40A16 16 0 0 1 76 40L80 62A20 20 0 0 1 40 62Z"/><circle class="k-pin" cx="60" cy="38" r="8.5"/><circle class="k-journal" cx="60" cy="60" r="9.5"/></g></svg>`;

const LAYOUTS = { single: "Single", "pressed-up-single": "Single, pressed up", "pressed-up-single-no-pin": "Single, pressed up, without its crankpin", "v-twin-45": "V-twin, 45°", "parallel-twin-360": "Parallel twin, 360°", "inline-3": "In-line 3", "inline-4": "In-line 4", "inline-6": "In-line 6", "v6-60": "V6, 60°", "v8-crossplane": "V8, cross-plane, 90°", "v8-flatplane": "V8, flat-plane", "v12-60": "V12, 60°" };
const preset = signal("");
export function Ways() {
  const { accept } = $("panel-open").dataset, files = ({ target }) => { const list = [...target.files]; target.value = ""; dropped(list); }; // the same file may be chosen again
  const says = sent.value ? t("sending {names} …", { names: sent.value }) : state.file ? `${state.file}${size()}` : t("No file yet");
  return html`<div class="ways"><section data-testid="drop" id="drop" class=${over.value ? "over" : ""}><h3>${t("My crank")}</h3><p>${t("Drop a crank, a job or a result's folder anywhere on this page, or choose files.")}</p>
      <input type="file" data-testid="file-input" id="file-input" aria-label=${t("Files of a crank, a job or a result")} multiple accept=${accept} onChange=${files}/>${isStart() ? html`<button type="button" class="main" onClick=${() => $("file-input").click()}>${t("Choose a file")}</button>` : ""}<p class="quiet" id="chosen">${says}</p><p class="quiet" id="formats">${t("Cranks: {endings}. Jobs: {jobs}. Results: their folder.", { endings: CRANKS.join(", "), jobs: JOBS.join(", ") })}</p></section>
    <section class="examples"><h3>${t("An example")}</h3><${Example} id="bundled" picture="example-motocross.png" name=${t("Motocross single")} says=${t("Lighter rod and pin, two faces to mill")} work=${() => example(null)}/><${Example} id="example-v8" picture="example-v8.png" name=${t("Cross-plane V8")} says=${t("With its weights, holes to drill")} work=${() => example("v8-crossplane", true)}/></section>
    <section><h3>${t("Draw one")}</h3><p>${t("From the dimensions of a usual crank. Stroke, counterweights and more can be changed afterwards.")}</p><label>${t("Layout")} <select id="preset" data-testid="preset" aria-label=${t("Layout of the crank to draw")} value=${preset.value || state.presets[0]} onInput=${({ target }) => { preset.value = target.value; }}>${state.presets.map((name) => html`<option value=${name}>${t(LAYOUTS[name] || name)}</option>`)}</select></label> <button type="button" id="draw-preset" data-testid="draw-preset" onClick=${() => example(preset.value || state.presets[0])}>${t("Draw it")}</button></section></div>`;
}
const Example = ({ id, picture, name, says, work }) => html`<button type="button" class="example" id=${id} data-testid=${id} onClick=${work}><img src=${`/static/${picture}`} alt="" width="92" height="64" loading="lazy"/><span><b>${name}</b><small>${says}</small></span></button>`;
const size = () => (long() === null ? "" : `: ${t("read in {unit}; {length} from the first web to the last", { unit: unitOfFile(), length: withUnit(long(), 0, "mm") })}`);

// --- where a person was -----------------------------------------------------------------------------------------

// The latest results, then cranks that have none.
function recent() {
  const made = results().slice(0, MOST_RECENT), with_ = new Set(results().map(({ crank }) => crank));
  const bare = [...new Set([...(state.file ? [state.file] : []), ...Object.keys(state.cranks)])].filter((file) => !with_.has(file));
  return [...made.map((told) => ({ told, file: told.crank || "" })), ...bare.map((file) => ({ file }))].slice(0, MOST_RECENT);
}
function Recent() {
  const list = recent();
  if (!list.length) return "";
  return html`<section class="recent" data-testid="recent" aria-labelledby="recent-head"><div class="top"><h2 id="recent-head">${t("Go on where you were")}</h2><button type="button" class="link" data-testid="all-cranks" onClick=${() => emit("tab", "history")}>${t("All cranks")} →</button></div><ul>${list.map((each) => html`<${Row} key=${each.told?.id || each.file} ...${each}/>`)}</ul></section>`;
}
function Row({ told, file }) {
  const report = told && reportOf(told.id), found = report && judgement(report, told), shape = report?.crank.throws;
  const work = () => { if (!told) again(file)(); else { emit("show", told); emit("tab", "see"); } };
  const words = [shape?.length ? t("Throws: {throws}, stroke {stroke}", { throws: shape.length, stroke: withUnit(2 * shape[0].crank_radius_mm, 1, "mm") }) : "", told ? when(told) : ""].filter((each) => each).join(" · ");
  return html`<li data-crank=${file} data-run=${told?.id}><${Picture} file=${file}/><span><button type="button" class="link" onClick=${work}>${crankName(file) || t("From elsewhere")}</button><small>${words}</small></span><span class="made">${!told ? t("No result yet") : report ? cutsOf(report) : "…"}</span>${found ? html`<span class="badge" data-tone=${found.tone}>${found.words}</span>` : html`<span></span>`}</li>`;
}
// A crank's small picture, where the page has taken one.
export const Picture = ({ file }) => (state.cranks[file]?.picture ? html`<img src=${`/api/cranks/picture?file=${encodeURIComponent(file)}&of=${state.cranks[file].picture}`} alt="" width="92" height="64"/>` : html`<span class="no-picture" aria-hidden="true"></span>`);
