// Parts: weights, targets and engine, and what they do to the crank as one types.
import { html, useEffect, useRef } from "/static/preact.min.js";
import { $, debounced, shown, typed, withUnit } from "/static/tools.js";
import { post } from "/static/server.js";
import { GROUPS, changed, emit, isWas, looked, on, state, sumOf } from "/static/job.js";
import { mount, redraw, signal } from "/static/store.js";
import { t } from "/static/words.js";
import { Engine, Targets } from "/static/engine.js";
import { Everything } from "/static/everything.js";
import { said } from "/static/said.js";
import { Factors } from "/static/factors.js";

export const preview = signal({ found: null, why: "" });

export function setUp() {
  on("job", ask);
  on("opened", ask);
  on("forgotten", () => { preview.value = { found: null, why: "" }; });
  mount(Parts, $("panel-parts"));
}

function Parts() {
  return html`<${Weights}/><${Targets}/><${Factors}/><${Engine}/><${Forces}/><${Facts}/><p class="quiet" id="preview-why" aria-live="polite">${preview.value.why}</p><${Everything}/>`;
}

// --- weights ----------------------------------------------------------------------------------------------

const before = signal(null); // whether the column of what the parts weighed before is shown; null: where the job has it
const more = signal(null); // whether pieces and ± are shown; null: where the job has any
export const showBefore = () => { before.value = true; };
const hasBefore = () => before.value ?? isWas();
const hasMore = () => more.value ?? Object.values(state.weights).some((rows) => rows.some((row) => row.pm !== "" || row.pieces !== ""));

export function Seg({ name, label, options, now, set }) {
  return html`<div class="seg" role="radiogroup" aria-label=${label}>${options.map(([value, words]) => html`<label data-testid=${`${name}-${value}`}><input type="radio" name=${name} checked=${now === value} onChange=${() => set(value)}/>${words}</label>`)}</div>`;
}

function Weights() {
  const toggle = () => { more.value = !hasMore(); };
  return html`<div class="top"><h2>${t("Weights in g")}</h2><${Seg} name="columns" label=${t("Columns")} options=${[["both", t("was | is")], ["is", t("is only")]]} now=${hasBefore() ? "both" : "is"} set=${(value) => { before.value = value === "both"; }}/></div>
    <p class="quiet tight">${t("One rod, one crankpin. Spreadsheet rows can be pasted.")}</p>
    <div id="weights" data-was=${String(hasBefore())} data-more=${String(hasMore())}>${Object.entries(GROUPS).map(([group, title]) => html`<${Group} group=${group} title=${t(title)}/>`)}</div>
    <p class="buttons"><button type="button" class="small" aria-pressed=${String(hasMore())} data-testid="more-columns" onClick=${toggle}>${t("Pieces and ± of the scale")}</button></p>`;
}

function Group({ group, title }) {
  const rows = state.weights[group], added = useRef(false), box = useRef(null);
  useEffect(() => { if (added.current) [...box.current.querySelectorAll("[data-testid=weight-name]")].pop()?.focus(); added.current = false; });
  const total = sumOf(rows), open = rows.filter((row) => row.raw === undefined && String(row.g).trim() === "").length;
  const words = [total === null ? "" : t("{sum} g in all", { sum: shown(total, 2) }), open ? t("{count} not weighed: not in the job", { count: open }) : ""];
  const add = () => { rows.push({ name: "", g: "", pm: "", pieces: "", isOwn: true }); added.current = true; redraw(); };
  return html`<div class="weights" role="group" aria-label=${title} ref=${box}><h3>${title}<span class="was">${t("was")}</span><span class="is">${t("is")}</span><span class="more">${t("pieces")}</span><span class="more">±</span></h3>
    ${rows.map((row, place) => html`<${Row} group=${group} title=${title} row=${row} place=${place}/>`)}
    <div class="foot"><p class="quiet" data-testid=${`sum-${group}`}>${words.filter((each) => each).join("; ")}</p><button type="button" class="small" aria-label=${`${t("Add a part")}: ${title}`} data-testid=${`add-${group}`} onClick=${add}>${t("Add a part")}</button></div></div>`;
}

// What a shop calls the usual parts; a part of one's own has the name that it was given.
const PARTS = { connecting_rod_big_end: "Rod, big end", big_end_bearing: "Big-end bearing", crankpin: "Crankpin", connecting_rod_small_end: "Rod, small end", small_end_bearing: "Small-end bearing", piston: "Piston", wrist_pin: "Wrist pin", rings_clips_oil: "Rings, clips, oil", oil: "Oil" };
const COLUMNS = [["was", "mass of each before, in grams"], ["g", "mass of each in grams"], ["pieces", "pieces"], ["pm", "plus or minus in grams"]];
function Row({ group, title, row, place }) {
  const known = !row.isOwn && PARTS[row.name], isRaw = row.raw !== undefined, called = `${title}, ${t("part {number}", { number: place + 1 })}`;
  const cell = ([key, words]) => {
    const fixed = isRaw || (key === "was" && row.wasRaw !== undefined), change = key === "was" ? "" : isChanged(row) ? " changed" : "";
    const placeholder = fixed && ["g", "was"].includes(key) ? t("in the job") : key === "pieces" && !fixed ? "1" : key === "was" ? row.g : "";
    return html`<input class=${`${{ was: "was", g: "is" }[key] || "more"}${key === "g" ? change : key === "was" && !isChanged(row) ? " same" : ""}`} value=${row[key] ?? ""} aria-label=${`${called}: ${t(words)}`} data-testid=${`weight-${key}`} inputMode="decimal" readOnly=${fixed} placeholder=${placeholder} onInput=${({ target }) => { row[key] = target.value; changed(); }}/>`;
  };
  const named = html`<input class="name" hidden=${Boolean(known)} value=${row.name} aria-label=${`${called}: ${t("name")}`} data-testid="weight-name" title=${t(row.hint || "")} onInput=${({ target }) => { row.name = target.value; changed(); }}/>`;
  const remove = () => { state.weights[group].splice(place, 1); changed(); };
  return html`<div data-testid="weight-row" data-group=${group} onPaste=${(event) => pasted(event, group, place)} onKeyDown=${down}>${known ? html`<span class="name" title=${t(row.hint || "")}>${t(known)}</span>` : ""}${named}${COLUMNS.map(cell)}<button type="button" class="bare" aria-label=${t("Remove {name}", { name: (known && t(known)) || row.name || t("this part") })} onClick=${remove}>×</button></div>`;
}
const isChanged = (row) => row.wasRaw === undefined && String(row.was ?? "").trim() !== "" && typed(row.was) !== typed(row.g);

// Enter goes down a column.
function down(event) {
  if (event.key !== "Enter" || event.ctrlKey || event.metaKey || event.target.tagName !== "INPUT") return;
  const column = [...document.querySelectorAll(`#weights [data-testid=${event.target.dataset.testid}]`)];
  column[column.indexOf(event.target) + 1]?.focus();
  event.preventDefault();
}

// Rows of a spreadsheet: name, grams, plus or minus; a row without a number is a heading.
function pasted(event, group, place) {
  const cells = event.clipboardData.getData("text").trim().split(/\r?\n/).map((text) => text.split("\t").map((cell) => cell.trim()));
  if (cells.length < 2 && cells[0].length < 2) return;
  event.preventDefault();
  const number = (text) => (text || "").replace(/\s*g$/, "").replace(",", "."), isNumber = (text) => text !== "" && Number.isFinite(Number(number(text)));
  const into = event.target.dataset.testid?.replace("weight-", "");
  if (into in state.weights[group][place] && into !== "name" && cells.every(([first]) => isNumber(first))) return filledDown(group, place, into, cells.map((row) => row.map(number)));
  const found = cells.map(([name, g, pm]) => ({ name: name.replace(/\s+/g, "_"), g: number(g), pm: number(pm).replace("±", ""), pieces: "" })).filter((row) => row.name && row.g !== "" && Number.isFinite(Number(row.g)));
  state.weights[group].splice(place, 1, ...found);
  changed();
}

// Numbers alone fill down from the field that they are pasted into, and right; other parts stay.
function filledDown(group, place, into, cells) {
  const columns = COLUMNS.map(([key]) => key), from = columns.indexOf(into);
  cells.forEach((row, k) => {
    const part = (state.weights[group][place + k] ||= { name: "", g: "", pm: "", pieces: "", isOwn: true });
    if (part.raw === undefined) row.forEach((text, j) => { if (columns[from + j]) part[columns[from + j]] = text; });
  });
  changed();
}

// --- as one types -----------------------------------------------------------------------------------------

let asked = 0;
const ask = debounced(async () => {
  if (!state.inspected) return;
  const mine = ++asked;
  let found = null, why = "";
  try { found = await post(`/api/runs/${state.inspected.id}/preview`, looked()); } catch (error) { why = error.message; }
  if (mine !== asked) return;
  if (found?.why) { why = said(found.why); found = null; }
  preview.value = { found, why };
}, 60);

const Predicted = ({ value, digits, unit = "" }) => html`<span class="predicted" data-predicted=${String(value)}>${unit ? withUnit(value, digits, unit) : shown(value, digits)}</span>`;

// The force that shakes the engine today, once the rod length is known.
function Forces() {
  const { greatest_n: greatest, speed_rpm: speed, why } = preview.value.found?.forces || {};
  if (greatest === undefined) return html`<p id="forces-line" hidden></p>`;
  return html`<p id="forces-line" data-testid="forces-line">${why ? said(why) : html`<span class="predicted" data-predicted=${String(greatest)}>${t("Forces today: up to {force} at {speed} rpm.", { force: `${shown(greatest, 0)} N`, speed: shown(speed, 0) })}</span>`} <button type="button" class="link" onClick=${() => emit("tab", "analyse")}>${t("Analyses")}</button></p>`;
}

function Facts() {
  const { found } = preview.value;
  const facts = !found ? [] : [
    ...found.bob_weights.map((each) => [t("Bob-weight, throw {number}", { number: each.throw }), each.mass_g, "g"]),
    [t("Balance factor before"), found.balance_factor.initial, ""],
    [t("Unbalance before"), found.initial.magnitude_g_mm, "g·mm"],
    [t("Permitted"), found.tolerance.permissible_g_mm, "g·mm"],
  ];
  return html`<div id="preview" data-testid="preview" hidden=${!found}><h2>${t("Before anything is cut")} <small>${t("predicted from the measured crank")}</small></h2>
    <dl id="preview-facts">${facts.map(([name, value, unit]) => html`<dt>${name}</dt><dd><${Predicted} value=${value} digits=${unit ? 2 : 4} unit=${unit}/></dd>`)}</dl></div>`;
}
