// Correct: kinds, limits, faces and angles picked in the model; cut and measure; alternatives as a board.
import { html } from "/static/preact.min.js";
import { $ } from "/static/tools.js";
import { guarded } from "/static/server.js";
import { answered, at, changed, emit, job, keep, on, state } from "/static/job.js";
import { WORDS, chosen, faces, forgetLimits, has, isPoint, kinds, limitOf, listed, methods, sectors, setLimit, zones } from "/static/limits.js";
import { Board, Why, compare, hasCompared } from "/static/board.js";
import { KindCards, kindWords } from "/static/kind-cards.js";
import { Field } from "/static/fields.js";
import { Measured, Predicted } from "/static/measured.js";
import { Cancel, Progress, RunList, start, watched } from "/static/runs.js";
import { ended } from "/static/see.js";
import { mount, signal } from "/static/store.js";
import { unitOf } from "/static/units.js";
import { plain, t } from "/static/words.js";
import { fromZero, zeroDeg, zeroWords } from "/static/zero.js";

let view = null;
const picking = signal(null); // angles of a zone that is being picked in the model
const says = signal(""); // what was picked
const kindOfZone = signal("allowed");

export function setUp(model) {
  view = model;
  mount(Correct, $("panel-correct"));
  on("job", marks);
  on("forgotten", forgetLimits);
}

// --- picked in the model ------------------------------------------------------------------------------------

function use(id, isUsed) {
  if (isUsed) faces.add(id); else faces.delete(id);
  changed();
}

// What is chosen, in the model's colours.
export function marks() {
  if (!view.parts.length || $("panel-correct").hidden) return;
  view.mark(view.parts.flatMap((part, k) => (part.kind === "face" && faces.has(part.id) ? [k + 1] : [])));
  view.sectors(hasZones() && zones.list.length ? sectors() : []);
}
const hasZones = () => has("sector_deg") || has("sectors_deg");

export function pickedInModel(hit) {
  if (!hit) return;
  if (picking.value) { angle(hit.point); return; }
  const part = view.parts[hit.part - 1];
  if (!has("faces") || !part || part.kind !== "face") { says.value = part ? t("A correction cannot use {part}.", { part: `${t(part.kind.replace("_", " "))} ${part.number}` }) : t("A correction cannot use this face."); return; }
  use(part.id, !faces.has(part.id));
  says.value = t(faces.has(part.id) ? "face {face} chosen" : "face {face} left out", { face: part.id });
}

function angle([x, y]) {
  const angles = [...picking.value, Math.round(((Math.atan2(y, x) * 180) / Math.PI + 360) % 360)];
  picking.value = angles.length === 1 ? angles : null;
  if (angles.length === 1) { says.value = t("from {from}°; click where it ends, counter-clockwise", { from: angles[0] }); return; }
  zones.list.push({ from: angles[0], to: angles[1], allowed: kindOfZone.value === "allowed" });
  says.value = t("{kind} from {from}° to {to}°", { kind: t(kindOfZone.value), from: angles[0], to: angles[1] });
  changed();
}
function pick() {
  picking.value = [];
  says.value = t("click in the model where the zone begins");
}

// --- cut and measure ----------------------------------------------------------------------------------------

export const balance = guarded(async (words) => {
  answered();
  emit("begun");
  const told = await watched(() => start("balance", { job: job() }, words || (listed.cuts ? t("listed cuts") : methods().map(kindWords).join(" + "))));
  if (told && await ended(told)) emit("tab", "see");
});

// --- the panel ----------------------------------------------------------------------------------------------

function Correct() {
  const options = kinds.list.map((kind) => html`<option value=${kind.name}>${kind.name === kind.noun.toLowerCase() ? kind.name : `${kind.name}: ${t(kind.noun).toLowerCase()}`}</option>`);
  const set = (key) => ({ target }) => { chosen[key] = target.value; chosen.others = []; changed(); };
  const judge = ({ target }) => { keep("balance.judge", target.value); changed(); };
  const isMixed = Boolean(chosen.also || chosen.others.length), used = methods().map(kinds.of).filter((kind) => kind);
  return html`<div class="top"><h2>${t("Kind of cut")}</h2><small>${hasCompared() ? t("left, in {unit}", { unit: unitOf("g·mm") }) : ""}</small></div><${KindCards}/><${Why}/>
    <p class="buttons"><button type="button" data-testid="compare" id="compare" onClick=${() => compare()}>${hasCompared() ? t("Compare again") : t("Compare all methods")}</button> <${Cancel}/></p><${Listed}/><${Progress}/>
    <div id="first-limits" data-testid="first-limits">${used.map((kind) => html`<${Limits} key=${kind.name} kind=${kind} isFirst/>`)}</div>
    <${Faces}/><${Zones}/><p class="quiet" id="pick-says" aria-live="polite">${says.value}</p>
    <details class="fold" open=${isMixed}><summary>${t("Mix with another kind")} <small>${isMixed ? methods().map(kindWords).join(" + ") : t("no")}</small></summary><div class="fields"><label>${t("Correction method")} <select data-testid="method" id="method" value=${chosen.method} onInput=${set("method")}>${options}</select></label>
    <label>${t("Mixed with")} <select data-testid="also" id="also" value=${chosen.also} onInput=${set("also")}><option value="">${t("nothing else")}</option>${options}</select></label>
    <label>${t("Verdict on")} <select data-testid="judge" id="judge" value=${at("balance.judge") || "dynamic"} onInput=${judge}><option value="dynamic">${t("resultant and planes")}</option><option value="static">${t("resultant alone")}</option></select></label></div></details>
    <details class="fold"><summary>${t("More limits")}</summary><div id="limits">${used.map((kind) => html`<${Limits} key=${kind.name} kind=${kind}/>`)}</div></details>
    <details class="fold" id="alternatives" hidden=${!hasCompared()}><summary>${t("All alternatives, with mixes")}</summary><${Board}/></details>
    <details class="fold" open><summary>${t("Runs")}</summary><${RunList}/></details>`;
}

// Cuts that the job lists are made as they are; given up, they are planned again.
export function Listed() {
  if (!listed.cuts) return "";
  const free = () => { listed.cuts = null; changed(); };
  return html`<p class="buttons" data-testid="listed">${t("The job lists {count} cuts. They are made exactly as listed.", { count: listed.cuts.length })} <button type="button" data-testid="plan-freely" onClick=${free}>${t("Plan freely again")}</button></p>`;
}

// What a shop knows first of a method; the rest is folded.
const FIRST = ["max_depth_mm", "min_radius_mm", "min_wall_mm", "depth_step_mm", "diameters_mm", "max_holes", "max_slugs", "cutter_mm"];
function Limits({ kind, isFirst = false }) {
  const set = (key) => (value) => { setLimit(kind.name, key, value); changed(); };
  const keys = kind.keys.filter(({ key }) => !(key in WORDS) && FIRST.includes(key) === isFirst);
  return keys.length ? html`<fieldset class="fields"><legend>${t("{kind}: limits", { kind: t(kind.noun) })}</legend>${keys.map((field) => html`<${Field} key=${field.key} id=${`limit-${kind.name}-${field.key}`} field=${field} now=${limitOf(kind.name, field.key)} set=${set(field.key)}/>`)}</fieldset>` : "";
}

function Faces() {
  const known = state.inspected?.report.faces || [], row = (id, words) => html`<label class="check" key=${id} data-face=${id}><input type="checkbox" checked=${faces.has(id)} onInput=${({ target }) => use(id, target.checked)}/> ${id} <small>${words}</small></label>`;
  return html`<details class="fold" id="faces-box" open hidden=${!has("faces")}><summary>${t("Faces to use")} <small>${t("leave empty for automatic choice, or click faces in the model")}</small></summary><div id="faces" data-testid="faces">
    ${[...faces].filter(isPoint).map((point) => row(point, t("the face at this point of the file [mm]")))}
    ${known.map((face, k) => row(face.id, html`${t("web")} ${face.web ?? "–"}, <${Measured} of=${`faces.${k}.area_mm2`} value=${face.area_mm2} digits=${0}/> ${unitOf("mm²")}, <${Predicted} value=${Math.hypot(...face.unbalance_per_mm_g_mm)} digits=${0}/> g·mm ${t("per")} mm`))}
    ${known.length ? "" : t("Open the crank first.")}</div></details>`;
}

function Zones() {
  const add = (zone) => { zones.list.push(zone); changed(); };
  return html`<details class="fold" id="zones-box" open hidden=${!hasZones()}><summary>${t("Angles about the axis")} <small>${zeroWords()}</small></summary>
    <div id="zones">${zones.list.map((zone, place) => html`<${Zone} key=${place} zone=${zone} place=${place}/>`)}</div>
    <p class="buttons"><button type="button" id="add-zone" onClick=${() => add({ from: 120, to: 240, allowed: true })}>${t("Allow a zone")}</button><button type="button" id="add-forbidden" onClick=${() => add({ from: 170, to: 190, allowed: false })}>${t("Forbid a zone")}</button>
    <button type="button" id="pick-zone" onClick=${pick}>${t("Pick in the model")}</button> <select id="zone-kind" aria-label=${t("Kind of the picked zone")} value=${kindOfZone.value} onInput=${({ target }) => { kindOfZone.value = target.value; }}><option value="allowed">${t("allowed")}</option><option value="forbidden">${t("forbidden")}</option></select></p></details>`;
}

// Angles of a zone count from the job's zero, as all that the page shows; a zone may end at the full turn.
const micro = (angle) => Math.round(1e6 * angle) / 1e6;
const zoneShown = (angle, key) => (zeroDeg() === 0 ? angle : micro(fromZero(angle)) || (key === "to" ? 360 : 0));
const zoneKept = (value) => (zeroDeg() === 0 ? value : micro((((value + zeroDeg()) % 360) + 360) % 360));
function Zone({ zone, place }) {
  const kind = t(zone.allowed ? "allowed" : "forbidden");
  const input = (key) => html`<input inputMode="decimal" value=${plain(zoneShown(zone[key], key))} aria-label=${`${t("zone {place}", { place: place + 1 })}, ${kind}, ${t(key)} [°]`} onInput=${({ target }) => { const value = Number(target.value.replace(",", ".")); if (target.value.trim() && Number.isFinite(value)) { zone[key] = zoneKept(value); changed(); } }}/>`;
  return html`<div class="zone"><span>${kind}</span>${input("from")}<span>${t("to")}</span>${input("to")}<span>°</span><button type="button" aria-label=${t("Remove {name}", { name: t("zone {place}", { place: place + 1 }) })} onClick=${() => { zones.list.splice(place, 1); changed(); }}>×</button></div>`;
}
