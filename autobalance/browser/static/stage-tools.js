// Instruments over the model: a degree wheel from the job's zero, a section, a measure between two points.
import { html } from "/static/preact.min.js";
import { $, shown, withUnit } from "/static/tools.js";
import { on, state } from "/static/job.js";
import { mount, redraw, signal } from "/static/store.js";
import { angleText, fromZero, sign, zeroDeg } from "/static/zero.js";
import { t } from "/static/words.js";

const EDGE_ON = 0.35; // component along the axis below which the wheel is seen from its edge
let view = null;
const isWheel = signal(false), isSection = signal(false), isMeasure = signal(false);
const points = signal([]); // at most two that were clicked: { point, round }
const cut = { axis: "z", at: 50, place: null };
const AXES = { z: "the axis", x: "the throw", y: "y" };
const STEP_DEG = 10, NAMED_DEG = 30, SHORT = 1.06, LONG = 1.12, NAME = 1.2; // of the crank's largest radius

export function setUp(model) {
  view = model;
  const before = { drawn: view.ondrawn, pick: view.onpick };
  view.ondrawn = () => { before.drawn?.(); follow(); };
  view.onpick = (hit) => { if (isMeasure.value) picked(hit); else before.pick?.(hit); };
  for (const name of ["opened", "result", "selected"]) on(name, () => { points.value = []; wheel(); if (isSection.value) sectioned(); });
  on("forgotten", () => { for (const each of [isWheel, isSection, isMeasure]) each.value = false; points.value = []; unsectioned(); wheel(); });
  mount(Tools, $("stage-tools"));
  mount(Says, $("stage-says"));
}

const isRotor = () => Boolean(state.inspected || state.result); // a bare solid has no axis yet
function Tools() {
  if (!isRotor()) return "";
  const button = (name, words, title, isOn, press) => html`<button type="button" data-testid=${`tool-${name}`} aria-pressed=${String(isOn.value)} title=${t(title)} onClick=${press}>${t(words)}</button>`;
  return html`${button("degrees", "Degrees", "Angles about the axis, from the zero of the job", isWheel, () => { isWheel.value = !isWheel.value; roomFor(isWheel.value); wheel(); })}${button("section", "Section", "Cut the view open across an axis", isSection, () => { isSection.value = !isSection.value; if (isSection.value) sectioned(); else unsectioned(); })}${button("measure", "Measure", "Click two points: distance, angle, radius", isMeasure, () => { isMeasure.value = !isMeasure.value; points.value = []; view.draw(); })}`;
}
function Says() {
  $("stage-says").hidden = !isSection.value && !isMeasure.value;
  return html`${isSection.value ? html`<${Section}/>` : ""}${isMeasure.value ? html`<${Measure}/>` : ""}`;
}

// --- section ------------------------------------------------------------------------------------------------

function sectioned() { cut.place = view.section(cut.axis, cut.at / 100); redraw(); }
function unsectioned() { cut.place = null; if (view.renderer) view.section("none", 0.5); }
function Section() {
  const set = (key) => ({ target }) => { cut[key] = key === "at" ? Number(target.value) : target.value; sectioned(); };
  return html`<div class="section-bar"><label>${t("Section across")} <select id="section" data-testid="section" value=${cut.axis} onInput=${set("axis")}>${Object.entries(AXES).map(([value, words]) => html`<option value=${value}>${t(words)}</option>`)}</select></label>
    <input type="range" id="section-at" data-testid="section-at" aria-label=${t("Place of the section")} min="0" max="100" value=${cut.at} onInput=${set("at")}/><output id="section-says">${cut.place === null ? "" : `${cut.axis} = ${withUnit(cut.place, 1, "mm")}`}</output></div>`;
}

// --- degree wheel -------------------------------------------------------------------------------------------

let drawn = null, names = [];
const way = (degrees) => { const turn = ((zeroDeg() + degrees) * Math.PI) / 180; return [Math.cos(turn), Math.sin(turn)]; };
// The wheel's names are outside of the crank: it is shown smaller while they are there.
const SMALLER = 0.8;
function roomFor(isOn) {
  if (!view.camera) return;
  view.room = isOn ? SMALLER : 1;
  if (view.camera.zoom === view.fitted) { view.fit(); return; }
  view.camera.zoom *= isOn ? SMALLER : 1 / SMALLER;
  view.camera.updateProjectionMatrix();
}
// The wheel stands at the end of the crank that is nearer to the eye.
function wheel() {
  if (drawn) { view.scene.remove(drawn.lines); drawn.lines.geometry.dispose(); drawn = null; }
  const size = isWheel.value && isRotor() && view.reach?.();
  if (size) {
    const ends = [];
    for (let degrees = 0; degrees < 360; degrees += STEP_DEG) {
      const [x, y] = way(degrees), [u, v] = way(degrees + STEP_DEG), long = degrees % NAMED_DEG ? SHORT : LONG;
      ends.push(size.radius * x, size.radius * y, 0, long * size.radius * x, long * size.radius * y, 0, size.radius * x, size.radius * y, 0, size.radius * u, size.radius * v, 0);
    }
    drawn = { ...size, lines: view.pieces.stroked(new Float32Array(ends), "mark") };
    view.scene.add(drawn.lines);
  }
  names = drawn ? Array.from({ length: 360 / NAMED_DEG }, (_, k) => k * NAMED_DEG) : [];
  $("wheel-names").replaceChildren(...names.map((degrees) => Object.assign(document.createElement("span"), { textContent: degrees ? `${degrees}°` : `0° ${sign()}` })));
  view.draw();
}

// --- measure ------------------------------------------------------------------------------------------------

function picked(hit) {
  if (!hit) return;
  points.value = [...(points.value.length > 1 ? [] : points.value), { point: hit.point, round: view.roundAt(hit) }];
  view.draw();
}
const radiusOf = ([x, y]) => Math.hypot(x, y), angleOf = ([x, y]) => (Math.atan2(y, x) * 180) / Math.PI;
function Measure() {
  const list = points.value, figure = (key, value, words) => html`<dd data-measured=${key} data-value=${String(value)}>${words}</dd>`;
  if (!list.length) return html`<p class="measure" role="status">${t("Click two points of the model.")}</p>`;
  const one = ({ point, round }, k) => html`<dt>${t("Point {number}", { number: k + 1 })}</dt><dd>${t("radius")} <b data-measured=${`radius-${k + 1}`} data-value=${String(radiusOf(point))}>${withUnit(radiusOf(point), 2, "mm")}</b>, <b data-measured=${`angle-${k + 1}`} data-value=${String(fromZero(angleOf(point)))}>${angleText(angleOf(point))}</b> <small class="ref">${sign()}</small>, z ${withUnit(point[2], 2, "mm")}${round ? html`, <span data-measured=${`diameter-${k + 1}`} data-value=${String(round)}>⌀ ${withUnit(round, 2, "mm")}</span>` : ""}</dd>`;
  if (list.length < 2) return html`<dl class="measure" role="status">${list.map(one)}</dl>`;
  const [a, b] = list.map(({ point }) => point), apart = Math.hypot(...a.map((value, axis) => value - b[axis])), between = Math.abs(((angleOf(b) - angleOf(a) + 540) % 360) - 180);
  return html`<dl class="measure" role="status" data-testid="measured">${list.map(one)}<dt>${t("Distance")}</dt>${figure("distance", apart, withUnit(apart, 2, "mm"))}<dt>${t("Angle between")}</dt>${figure("between", between, `${shown(between, 1)}°`)}<dt>${t("Along the crank")}</dt>${figure("along", Math.abs(a[2] - b[2]), withUnit(Math.abs(a[2] - b[2]), 2, "mm"))}</dl>`;
}

// --- what stands over the model follows it ------------------------------------------------------------------

function put(each, point) {
  const [x, y] = view.placed(point);
  each.style.setProperty("left", `${x.toFixed(1)}px`);
  each.style.setProperty("top", `${y.toFixed(1)}px`);
}
function follow() {
  if (drawn) {
    $("wheel-names").hidden = Math.abs(view.eye()[2]) < EDGE_ON; // from the side they would lie over one another
    const z = view.eye()[2] < 0 ? drawn.z[0] : drawn.z[1];
    if (drawn.lines.position.z !== z) { drawn.lines.position.z = z; view.draw(); }
    names.forEach((degrees, k) => { const [x, y] = way(degrees); put($("wheel-names").children[k], [NAME * drawn.radius * x, NAME * drawn.radius * y, z]); });
  }
  const dots = $("measure-dots");
  while (dots.children.length > points.value.length) dots.lastChild.remove();
  while (dots.children.length < points.value.length) dots.append(Object.assign(document.createElement("span"), { textContent: String(dots.children.length + 1) }));
  points.value.forEach(({ point }, k) => put(dots.children[k], point));
}
