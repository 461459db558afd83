// Machine: what a balancing machine reads becomes the next cuts; every stage with its files.
import { html } from "/static/preact.min.js";
import { $, listTyped, shown, withUnit } from "/static/tools.js";
import { guarded, post, say } from "/static/server.js";
import { emit, on, state } from "/static/job.js";
import { runOf, start } from "/static/runs.js";
import { Any } from "/static/fields.js";
import { Cuts } from "/static/cuts.js";
import { Measured } from "/static/measured.js";
import { Polar } from "/static/polar.js";
import { mount, redraw, signal } from "/static/store.js";
import { ended } from "/static/see.js";
import { angleText, sign, zeroDeg, zeroWords } from "/static/zero.js";
import { said } from "/static/said.js";
import { t } from "/static/words.js";
import { BigDigits, cutsDone, onItsOwn } from "/static/big-digits.js";

const KEPT = "autobalance-shop"; // what a shop's machine is like, from one crank to the next
const OF_THE_SHOP = ["urr", "umar", "rotation", "zero", "reads"];
const DRAFT = "autobalance-reading"; // what is typed of a reading on a result, until it is followed
export const read = { planes: "2", urr: 95, umar: 0.5, rotation: "ccw", zero: 0, reads: "heavy", ...JSON.parse(localStorage.getItem(KEPT) || "{}") };
const stages = signal({ list: [], id: "" });
export const refused = signal(""); // why a reading was not followed
export const big = signal(false);
const index = { first: {}, second: {}, found: null };

export function set(key, value) {
  read[key] = value;
  localStorage.setItem(KEPT, JSON.stringify(Object.fromEntries(OF_THE_SHOP.map((name) => [name, read[name]]))));
  if (state.result) localStorage.setItem(`${DRAFT}-${state.result.id}`, JSON.stringify(Object.fromEntries(Object.entries(read).filter(([name]) => !OF_THE_SHOP.includes(name)))));
  redraw();
}
// The reading that was begun on a result; none of another's.
function taken(id) {
  for (const name of Object.keys(read)) if (!OF_THE_SHOP.includes(name)) delete read[name];
  Object.assign(read, { planes: "2" }, JSON.parse(localStorage.getItem(`${DRAFT}-${id}`) || "{}"));
}

export function setUp() {
  mount(Machine, $("spin"));
  on("result", ({ report, id }) => {
    taken(id);
    const names = report.tolerance.planes.map((plane) => plane.name);
    for (const number of [1, 2]) read[`at-${number}`] = read[`at-${number}`] || names[number - 1];
    if (names.length < 2) read.planes = "1";
    refused.value = "";
    stages.value = { list: report.stages || [], id };
  });
}

// --- the reading ------------------------------------------------------------------------------------------

const number = (key, words, unit = "", usual = "") => [key, { key, words, unit, kind: "number", default: usual }];
const text = (key, words, usual = "") => [key, { key, words, unit: "", kind: "text", default: usual }];
const choice = (key, words, options) => [key, words, options];
const One = ({ field: [key, declared], before = "" }) => html`<${Any} id=${before + key} testid=${before + key} field=${declared} now=${read[key]} set=${(value) => set(key, value)} help=${false} wrong=${isTouched(key) ? missing()[key] || "" : ""}/>`;
// A field that was never typed in says nothing yet.
const isTouched = (key) => key in read && (read[key] !== undefined || OF_THE_SHOP.includes(key));
const Choice = ({ of: [key, words, options], testid = key }) => html`<label>${t(words)}<select id=${testid} data-testid=${testid} value=${read[key]} onInput=${({ target }) => set(key, target.value)}>${options.map(([value, says]) => html`<option value=${value}>${t(says)}</option>`)}</select></label>`;

export function Plane({ place, before = "" }) {
  return html`<fieldset class="fields" id=${`${before}plane-${place}`} hidden=${place === 2 && read.planes === "1"}><legend>${t(place === 1 ? "First plane" : "Second plane")}</legend>
    ${before ? "" : html`<${One} field=${text(`at-${place}`, "at A, B or z [mm]")}/>`}<${One} before=${before} field=${number(`g-mm-${place}`, "Unbalance", "g·mm")}/><${One} before=${before} field=${number(`angle-${place}`, "Angle", "°")}/></fieldset>`;
}

// The machine's zero in the rotor's frame: it counts from the job's.
const zero = () => (Number(read.zero) || 0) + zeroDeg();

// The heavy side in the rotor's frame, as the program takes the reading.
export function heavy(place) {
  const size = read[`g-mm-${place}`], angle = read[`angle-${place}`];
  if (typeof size !== "number" || typeof angle !== "number") return null;
  const turned = (zero() + (read.reads === "light" ? 180 : 0) + (read.rotation === "cw" ? -angle : angle)) * Math.PI / 180;
  return { unbalance_g_mm: [size * Math.cos(turned), size * Math.sin(turned)], magnitude_g_mm: size, name: "read" };
}

export function Heavy({ place }) {
  const vector = heavy(place), planes = state.result?.report.tolerance.planes || [];
  const permitted = planes.length < 2 || read.planes === "1" ? state.result?.report.tolerance.permissible_g_mm : planes[place - 1].permissible_g_mm;
  const words = `${t("Plane")} ${read[`at-${place}`] || place}`, left = state.result?.report.residual, expected = planes.length < 2 || read.planes === "1" ? left : left?.planes[place - 1];
  const rows = [[t("read"), vector ? html`<strong>${shown(vector.magnitude_g_mm, 2, "g·mm")}</strong>` : "–"], [t("heavy at"), vector ? html`${angleText((Math.atan2(vector.unbalance_g_mm[1], vector.unbalance_g_mm[0]) * 180) / Math.PI)}<small class="ref"> ${sign()}</small>` : "–"], ...(expected ? [[t("expected"), html`${shown(expected.magnitude_g_mm, 2, "g·mm")}${typeof expected.uncertainty_g_mm === "number" ? html` <span>± ${shown(expected.uncertainty_g_mm, 2, "g·mm")}</span>` : ""}`, "wraps"]] : []), [t("permitted"), withUnit(permitted, 2, "g·mm")]];
  return html`<${Polar} expected=${expected} testid=${`read-polar-${place}`} within=${vector ? String(vector.magnitude_g_mm <= permitted) : ""} title=${words} vectors=${[vector || { magnitude_g_mm: null, unbalance_g_mm: [0, 0], name: "read" }]} permitted=${permitted} rows=${rows}/>`;
}

function body() {
  const plane = (place) => {
    const at = String(read[`at-${place}`] ?? "").trim(), z = Number(at);
    return { ...(/^[AB]$/i.test(at) ? { at: at.toUpperCase() } : at === "" ? {} : { z_mm: Number.isFinite(z) ? z : at }), g_mm: read[`g-mm-${place}`] ?? "", angle_deg: read[`angle-${place}`] ?? "" };
  };
  const made = { urr_percent: read.urr ?? "", umar_g_mm: read.umar ?? "", rotation: read.rotation, reads: read.reads, zero_deg: zero(), plane: read.planes === "2" ? [plane(1), plane(2)] : [plane(1)] };
  if (read["reading-speed"] !== undefined) made.speed_rpm = read["reading-speed"];
  if (read.serial) made.serial = String(read.serial);
  if (read["bob-weights"]) made.bob_weights_g = listTyped(read["bob-weights"]);
  return made;
}

// What a reading still needs, by its field: what is typed there is no number, or nothing.
export function missing() {
  const found = {}, isNumber = (value) => typeof value === "number";
  const need = (key, words) => { if (!isNumber(read[key])) found[key] = read[key] === undefined || read[key] === "" ? words : t("{value} is not a number", { value: read[key] }); };
  for (const place of read.planes === "2" ? [1, 2] : [1]) {
    need(`g-mm-${place}`, t("Enter the amount that the machine reads."));
    need(`angle-${place}`, t("Enter the angle that the machine reads."));
  }
  need("umar", t("Enter the minimum achievable residual of the machine."));
  need("urr", t("Enter the machine's reduction ratio."));
  return found;
}

export const recut = guarded(async (trust) => {
  if (!state.result) throw new Error(t("balance a crank first"));
  refused.value = "";
  try {
    const told = await start("recut", { run: state.result.id, reading: body(), trust_reading: trust }, t("from a reading"));
    if (told && await ended(told)) { say(""); $("panels").scrollTop = 0; }
  } catch (error) {
    const isDoubted = error.message.includes("--trust-reading"); // the page has a button for that option
    if (isDoubted) refused.value = error.message.replace(/(;|,? or use) --trust-reading( goes on)?/, "").replace(/^[a-z_]+: /, "");
    say(isDoubted ? refused.value : error.message);
  }
});

// --- the panel --------------------------------------------------------------------------------------------

function Machine() {
  const report = state.result?.report;
  if (!report) return html`<p id="machine-none">${t("Balance a crank first; then spin it and enter what the machine reads.")}</p>`;
  const bobs = report.engine.bob_weights;
  const isNext = report.command === "recut", turn = Math.max(1, stages.value.list.length);
  return html`${isNext ? html`${report.corrections.length ? html`<${Cuts} id="next-cuts" title=${t("The next cuts")} corrections=${report.corrections}/>` : html`<p class="quiet">${t("Nothing more to cut")}</p>`}` : ""}<h2 data-testid="reading-turn">${t("Reading {number}", { number: turn })}</h2><${Bobs} bobs=${bobs}/><p class="quiet tight">${zeroWords()}. ${t("Readings have the same zero.")}</p><${Plane} place=${1}/><${Plane} place=${2}/>
    <div class="fields"><${Choice} of=${choice("planes", "Planes read", [["2", "two"], ["1", "one"]])} testid="reading-planes"/><${One} field=${number("reading-speed", "Speed", "1/min")}/><${One} field=${text("serial", "Serial number")}/><${One} field=${text("bob-weights", "Bob-weights fitted [g]", bobs.map((each) => (each.fit_g ?? each.mass_g).toFixed(2)).join("; "))}/></div>
    <details><summary>${t("The machine")} <small>${t("kept from one crank to the next")}</small></summary><div class="fields">
    <${One} field=${number("urr", "Unbalance reduction ratio URR", "%")}/><${One} field=${number("umar", "Minimum achievable residual Umar", "g·mm")}/>
    <${Choice} of=${choice("rotation", "Angles increase", [["ccw", "counter-clockwise"], ["cw", "clockwise"]])}/><${One} field=${number("zero", "Machine zero at", "°")}/><${Choice} of=${choice("reads", "The machine shows", [["heavy", "the heavy side"], ["light", "the light side"]])}/></div></details>
    <p class="buttons"><button type="button" id="trust" data-testid="trust" hidden=${!refused.value} onClick=${() => recut(true)}>${t("The reading is right: continue")}</button></p><p class="quiet" id="recut-needs" data-testid="recut-needs" aria-live="polite">${Object.values(missing())[0] || ""}</p>
    <p class="buttons"><span id="cuts-done" data-testid="cuts-done">${t("Cuts done: {done} of {count}", { done: cutsDone(report.corrections), count: report.corrections.length })}</span> <button type="button" class="small" data-testid="big-apart" onClick=${onItsOwn}>${t("On a screen of its own")}</button></p><${Suspects}/><${Stages}/><${IndexTest}/><${BigDigits}/>`;
}

// What to clamp on before it is spun; said once where it is the same for all throws.
function Bobs({ bobs }) {
  const told = (k) => html`<${Measured} of=${`engine.bob_weights.${k}.fit_g`} value=${bobs[k].fit_g}/> g, ± <${Measured} of=${`engine.bob_weights.${k}.tolerance_g`} value=${bobs[k].tolerance_g}/> g. `;
  const isSame = bobs.length > 1 && bobs.every((each) => each.fit_g === bobs[0].fit_g && each.tolerance_g === bobs[0].tolerance_g);
  return html`<p class="quiet tight" id="bob-card">${isSame ? html`${t("Each of {count} throws: clamp on", { count: bobs.length })} ${told(0)}` : bobs.map((each, k) => html`<span>${t("Throw {number}: clamp on", { number: each.throw })} ${told(k)}</span>`)}</p>`;
}

function Suspects() {
  const { list } = stages.value, report = state.result.report;
  const amount = (k, place, key, value) => html`<${Measured} of=${`stages.${k}.suspects.${place}.${key}`} value=${value} digits=${1} named/>`;
  const found = list.flatMap((stage, k) => stage.suspects.map((each, place) => html`<li>${t("Stage")} ${stage.stage}: ${said(each.key)}: ${said(each.says)} (${amount(k, place, "difference_g_mm", each.difference_g_mm)} ${t("apart")}, ${amount(k, place, "left_g_mm", each.left_g_mm)} ${t("left")})</li>`));
  const warned = report.command === "recut" ? report.warnings : [];
  return html`<ul id="suspects" data-testid="suspects" aria-label=${t("Checks")} aria-live="polite">${refused.value ? html`<li>${said(refused.value)}</li>` : ""}${found}${warned.map((words) => html`<li>${said(words)}</li>`)}</ul>`;
}

function Stages() {
  const { list, id } = stages.value;
  const amount = (k, key, values) => html`<td>${values ? html`<${Measured} of=${`stages.${k}.${key}.magnitude_g_mm`} value=${values.magnitude_g_mm} named/>` : "–"}</td>`;
  const rows = list.map((stage, k) => {
    const own = k === list.length - 1 ? id : stage.report.split("/").slice(-2)[0], url = (name) => `/api/runs/${own}/files/${encodeURIComponent(name)}`;
    const solid = runOf(own)?.files.find((name) => name.startsWith("balanced."));
    return html`<tr><th scope="row">${stage.stage}</th>${amount(k, "reading", stage.reading)}${amount(k, "expected", stage.expected)}<td>${stage.corrections}</td>${amount(k, "predicted", stage.predicted)}<td><a href=${url("report.json")} download=${`stage-${stage.stage}.json`}>${t("report")}</a> ${solid ? html`<a href=${url(solid)} download=${`stage-${stage.stage}-${solid}`}>${t("solid")}</a>` : ""}</td></tr>`;
  });
  return html`<table id="stages" data-testid="stages" hidden=${!list.length}><caption>${t("Stages; magnitudes of the resultant")}</caption>
    <thead><tr>${["stage", "read", "expected", "cuts", "left after", "files"].map((words) => html`<th scope="col">${t(words)}</th>`)}</tr></thead><tbody>${rows}</tbody></table>`;
}

// --- index test -------------------------------------------------------------------------------------------

const separate = guarded(async () => {
  const each = [index.first, index.second];
  index.found = await post("/api/index-test", { turned_deg: [0, index.second.turned ?? 180], readings_g_mm: each.map(({ size }) => size ?? ""), readings_deg: each.map(({ angle }) => angle ?? "") });
  redraw();
});
function IndexTest() {
  const { found } = index;
  const cell = (name, key, words, unit, usual) => html`<${Any} id=${`index-${name}-${key}`} field=${{ key, words, unit, kind: "number", default: usual }} now=${index[name][key]} set=${(value) => { index[name][key] = value; redraw(); }} help=${false}/>`;
  const facts = found && [["Crank", found.crank_g_mm, found.crank_deg], ["Tooling", found.tooling_g_mm, found.tooling_deg]];
  return html`<details id="index-test"><summary>${t("Index test")} <small>${t("separates the tooling from the crank")}</small></summary><p class="quiet">${t("Read one plane, turn the crank on its tooling, usually by 180°, and read again.")}</p>
    <div class="fields">${cell("first", "size", "First reading", "g·mm", "")}${cell("first", "angle", "Angle", "°", "")}${cell("second", "turned", "Turned by", "°", "180")}${cell("second", "size", "Second reading", "g·mm", "")}${cell("second", "angle", "Angle", "°", "")}</div>
    <p class="buttons"><button type="button" data-testid="index-test" onClick=${separate}>${t("Separate crank and tooling")}</button></p>
    <dl aria-live="polite" data-testid="index-found">${facts ? facts.map(([name, size, angle]) => html`<dt>${t(name)}</dt><dd>${withUnit(size, 2, "g·mm")} ${t("at")} ${shown(angle, 1)}°</dd>`) : ""}</dl></details>`;
}
