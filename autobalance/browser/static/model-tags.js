// Over the model: a cube that turns with it, names of what is seen, the tolerance planes, and arrows at the heavy side.
import { html } from "/static/preact.min.js";
import { $ } from "/static/tools.js";
import { on, state } from "/static/job.js";
import { heavy, read } from "/static/machine.js";
import { ink } from "/static/pieces.js";
import { preview } from "/static/parts.js";
import { mount } from "/static/store.js";
import { places } from "/static/verdict.js";
import { angleText, sign } from "/static/zero.js";
import { t } from "/static/words.js";

const T = window.THREE;
let view = null;

export function setUp(model) {
  view = model;
  const before = view.ondrawn;
  view.ondrawn = () => { before?.(); follow(); };
  mount(Cube, $("cube"));
  mount(Tags, $("model-tags"));
  for (const name of ["opened", "result", "selected", "forgotten"]) on(name, () => { drawnFor = ""; });
}

// --- the cube -------------------------------------------------------------------------------------------------

// Each face with the way out of it and its upper edge, rotor frame: crankpin 1 is above.
const FACES = [["Front", [0, 0, -1], [1, 0, 0]], ["Rear", [0, 0, 1], [1, 0, 0]], ["Side", [0, 1, 0], [1, 0, 0]], ["Far side", [0, -1, 0], [1, 0, 0]], ["Top", [1, 0, 0], [0, 0, -1]], ["Bottom", [-1, 0, 0], [0, 0, -1]]];
const HALF_PX = 23, EDGE_ON = 0.04;
const cross = ([a, b, c], [x, y, z]) => [b * z - c * y, c * x - a * z, a * y - b * x];
const dot = (one, other) => one.reduce((sum, value, axis) => sum + value * other[axis], 0);

function Cube() {
  return html`${FACES.map(([name, out]) => html`<button type="button" key=${name} data-testid="cube-face" data-face=${name} aria-label=${t("View from: {side}", { side: t(name) })} onClick=${() => view.turnTo(out, null)}>${t(name)}</button>`)}`;
}
// A face of a cube seen from far away is a square, skewed.
function turnCube() {
  const [side, up, eye] = view.axes(), at = (vector) => [dot(vector, side), -dot(vector, up)].map((value) => value.toFixed(4));
  FACES.forEach(([, out, top], k) => {
    const face = $("cube").children[k], [x, y] = at(out), away = dot(out, eye);
    face.hidden = away < EDGE_ON;
    if (!face.hidden) face.style.setProperty("transform", `matrix(${[...at(cross(top, out)), ...at(top.map((each) => -each))].join(",")},${HALF_PX * x},${HALF_PX * y})`);
  });
}

// --- what is said ---------------------------------------------------------------------------------------------

const MANY_WEBS = 4; // a crank with more has its journals and throws named alone
const LABEL = 1.12; // of the crank's largest radius: where a plane's ring is named
const DOWN = [0, 0.6, -0.6, 1.2, -1.2, 1.8, -1.8, 2.4, -2.4, Math.PI];

// Parts of the crank: each with places on it, of which the first that is seen has the name.
function parts() {
  const crank = state.inspected?.report.crank, anatomy = view.sets.crank?.anatomy;
  if (!crank || !anatomy || view.mode !== "crank") return [];
  const round = ({ centre_mm: [x, y, z], diameter_mm: wide, width_mm: long }) => (eye) => {
    const across = Math.hypot(eye[0], eye[1]), r = 0.5 * wide, end = z + Math.sign(eye[2]) * 0.5 * long;
    return [...(across > 0.1 ? [[x + (r * eye[0]) / across, y + (r * eye[1]) / across, z]] : []), [x, y, end], [x + 0.8 * r, y, end]];
  };
  const names = [...crank.main_journals.map((each) => [t("Main journal {number}", each), "journal", round(each)]), ...crank.throws.map((each) => [t("Throw {number}", each), "pin", round(each.crankpin)])];
  if (crank.webs.length <= MANY_WEBS) {
    const weighted = crank.webs.filter((web) => web.counterweight && web.outline);
    weighted.forEach((web, k) => {
      const [low, high, x, y] = anatomy.weights[k], rim = web.outline.rim_radius_mm;
      const at = (share, turn, z) => { const c = Math.cos(turn), s = Math.sin(turn); return [share * rim * (x * c - y * s), share * rim * (x * s + y * c), z]; };
      const around = (shares, turns) => (eye) => shares.flatMap((share) => turns.flatMap((turn) => [share === 1 ? at(1, turn, 0.5 * (low + high)) : at(share, turn, eye[2] > 0 ? high : low)]));
      names.push([t("Counterweight {number}", web), "weight", around([0.75, 0.6, 1], [0, 0.5, -0.5, 1, -1])]);
      names.push([t("Web {number}", web), "web", around([0.6, 0.8, 1, 0.45], [1.9, -1.9, 2.4, -2.4, Math.PI])]);
    });
  }
  return names.map(([words, colour, spots]) => ({ words, colour, spots }));
}

// Tolerance planes and where they are heavy, as the open step knows it: before any cut, left by the cuts, or read.
function planes() {
  const tab = document.body.dataset.tab, report = state.result?.report;
  const [what, tolerance] = ["parts", "correct"].includes(tab) ? [preview.value.found?.initial, preview.value.found?.tolerance] : ["see", "machine"].includes(tab) ? [report?.residual, report?.tolerance] : [];
  if (!what || !view.sets[view.mode]) return { rings: [], arrows: [] };
  const rings = tolerance.planes.map(({ name, z_mm: z }) => ({ name, z }));
  if (tab === "machine") return { rings, arrows: [1, 2].flatMap((place) => readAt(place, rings, tolerance)) };
  const each = places(what, tolerance).slice(rings.length ? 1 : 0);
  return { rings, arrows: each.flatMap(([, vector, permitted], k) => arrow(vector, permitted, rings[k]?.z)) };
}
function arrow({ unbalance_g_mm: [x, y], magnitude_g_mm: size }, permitted, z = view.sets[view.mode].sphere.center.z) {
  return size > permitted ? [{ z, angle: Math.atan2(y, x), size }] : [];
}
function readAt(place, rings, tolerance) {
  const vector = place === 2 && read.planes === "1" ? null : heavy(place), at = read[`at-${place}`], ring = rings.find(({ name }) => name === at), z = ring?.z ?? Number(at);
  const permitted = rings.length < 2 || read.planes === "1" ? tolerance.permissible_g_mm : tolerance.planes[place - 1].permissible_g_mm;
  return vector && Number.isFinite(z) ? arrow(vector, permitted, z) : [];
}

// Both ends of the crank: nose and flange where a keyway or a flange tells which, else as the axis points.
function ends() {
  const datums = (state.result?.report || state.inspected?.report)?.crank?.datums, set = view.sets[view.mode];
  if (!datums || !set || !view.renderer) return [];
  const { ends: [low, high], radius } = reachOf(), long = high - low, keyed = datums.keyways.map(({ end }) => end), flanged = datums.flanges.map(({ end }) => end);
  const isAtOne = (list, end) => list.includes(end) && list.every((each) => each === end);
  return [["-z", low, -1], ["+z", high, 1]].map(([end, z, way]) => {
    const axis = end.replace("-", "\u2212"), name = isAtOne(flanged, end) ? t("flange") : isAtOne(keyed, end) ? t("nose") : "";
    const spots = () => {
      const beyond = PAST.map((share) => [0, 0, z + way * share * long]), up = view.axes()[1];
      return Math.abs(view.eye()[2]) > END_ON ? [beyond[0], [-BELOW * radius * up[0], -BELOW * radius * up[1], z]] : beyond;
    };
    return { kind: "end", words: name ? `${name} (${axis})` : axis, spots, isFree: true, isSecond: () => Math.abs(view.eye()[2]) > END_ON };
  });
}
const PAST = [0.04, 0.01, -0.03, -0.06], END_ON = 0.9, BELOW = 1.15; // of the crank's length from its end; component along the axis; of its largest radius

let tags = [], drawn = null, drawnFor = "", looked = "";
function Tags() {
  if (!view.renderer) return "";
  const known = new Map(tags.map(({ words, size }) => [words, size])), { rings, arrows } = planes(), named = document.body.dataset.tab === "open" ? parts() : [], radius = rings.length + arrows.length ? reach() : 0;
  tags = [
    ...rings.map(({ name, z }) => ({ kind: "plane", words: name, spots: () => onRing(radius, z) })),
    ...arrows.map(({ z, angle }) => ({ kind: "heavy", words: `${t("heavy at")} ${angleText((angle * 180) / Math.PI)} ${sign()}`, spots: () => [[TIP * radius * Math.cos(angle), TIP * radius * Math.sin(angle), z]], isFree: true })),
    ...ends(),
    ...named.map((each) => ({ kind: "part", ...each })),
  ].map((tag) => ({ ...tag, size: known.get(tag.words) }));
  const now = JSON.stringify([view.mode, view.count, rings, arrows, tags.map(({ words }) => words)]);
  if (now !== drawnFor) {
    drawnFor = now;
    looked = "";
    inScene(view.mode === "crank" ? rings : [], arrows, radius); // a result has its rings
  }
  return tags.map(({ kind, words, colour }, k) => html`<span key=${k} class=${`tag ${kind}`} data-tag=${kind}>${colour ? html`<i class="swatch" style=${{ "--c": `var(--${colour})` }}></i>` : ""}${words}</span>`);
}
// How far the shown crank reaches from its axis; it is asked for again and again.
let reached = { of: null, size: null };
function reachOf() {
  const set = view.sets[view.mode];
  if (reached.of !== set) reached = { of: set, size: { ...view.reach(), ends: along(view.corners()) } };
  return reached.size;
}
function along(p) {
  let low = Infinity, high = -Infinity;
  for (let k = 2; k < p.length; k += 3) { if (p[k] < low) low = p[k]; if (p[k] > high) high = p[k]; }
  return [low, high];
}
const reach = () => reachOf().radius;

// --- in the scene ---------------------------------------------------------------------------------------------

const FROM = 1.04, TIP = 1.36, SHORTEST = 0.14, HEAD = 0.08, WIDE = 0.035; // of the crank's largest radius
// An arrow away from the axis, as two blades across each other: it is seen from every side.
function arrowEnds({ z, angle, size }, most, radius) {
  const [c, s] = [Math.cos(angle), Math.sin(angle)], tip = FROM + Math.max(SHORTEST, (TIP - FROM - 0.04) * (size / most)), neck = tip - HEAD, ends = [];
  for (const blade of [[-s, c, 0], [0, 0, 1]]) {
    const at = (out, aside) => [out * c + aside * blade[0], out * s + aside * blade[1], aside * blade[2]].map((value, axis) => radius * value + (axis === 2 ? z : 0));
    const shaft = [at(FROM, -WIDE / 3), at(neck, -WIDE / 3), at(neck, WIDE / 3), at(FROM, WIDE / 3)];
    ends.push(...shaft[0], ...shaft[1], ...shaft[2], ...shaft[0], ...shaft[2], ...shaft[3], ...at(neck, -WIDE), ...at(tip, 0), ...at(neck, WIDE));
  }
  return ends;
}
function inScene(rings, arrows, radius) {
  if (drawn) { view.scene.remove(drawn); drawn.traverse((each) => { each.geometry?.dispose(); each.material?.dispose(); }); drawn = null; }
  const most = Math.max(...arrows.map(({ size }) => size));
  if (rings.length + arrows.length) {
    drawn = group(rings.map(({ z }) => view.pieces.ring(z, 1.1 * radius, "zone")), arrows.flatMap((each) => arrowEnds(each, most, radius)));
    drawn.userData.arrows = arrows;
    view.scene.add(drawn);
  }
  view.beside = arrows.flatMap(({ z, angle }) => [TIP * radius * Math.cos(angle), TIP * radius * Math.sin(angle), z]);
  if (view.sets[view.mode] && view.camera.zoom === view.fitted) view.fit();
  view.draw();
}
// Lines, and blades given as corners of triangles, as one group.
function group(lines, corners) {
  const made = new T.Group(), shape = new T.BufferGeometry();
  shape.setAttribute("position", new T.BufferAttribute(new Float32Array(corners), 3));
  const blades = new T.Mesh(shape, new T.MeshBasicMaterial({ color: ink("heavy"), side: T.DoubleSide }));
  blades.userData.ink = "heavy";
  made.add(...lines, blades);
  return made;
}
// Where a ring may be named: at its top as it is seen, else further down it.
function onRing(radius, z) {
  const [side, up] = view.axes(), long = Math.hypot(up[0], up[1]), top = long > 0.2 ? Math.atan2(up[1], up[0]) : Math.atan2(side[1], side[0]);
  return DOWN.map((turn) => [LABEL * radius * Math.cos(top + turn), LABEL * radius * Math.sin(top + turn), z]);
}

// --- what stands over the model follows it ----------------------------------------------------------------------

const APART_PX = 3;
function follow() {
  turnCube();
  const box = $("model-tags");
  if (box.children.length !== tags.length || !tags.length) return;
  const { matrixWorld, zoom, right, top: high } = view.camera, seenFrom = `${matrixWorld.elements.join()} ${zoom} ${right} ${high} ${drawnFor}`;
  if (seenFrom === looked || !box.offsetWidth) return;
  const { clientWidth: width, clientHeight: height } = view.box;
  if (!view.turning) { looked = seenFrom; seen(); }
  const taken = [$("cube"), ...document.querySelectorAll("#stage .tools")].map((each) => each.getBoundingClientRect()).filter((each) => each.width), frame = view.box.getBoundingClientRect();
  if (tags.some(({ size }) => !size)) {
    for (const made of box.children) made.hidden = false;
    tags.forEach((tag, k) => { tag.size = [box.children[k].offsetWidth, box.children[k].offsetHeight]; });
  }
  const said = new Set(), isApart = (rect) => !taken.some((other) => rect.left < other.right && other.left < rect.right && rect.top < other.bottom && other.top < rect.bottom);
  tags.forEach((tag, k) => {
    const made = box.children[k];
    const [wide, high] = tag.size, spots = tag.kind === "part" ? (tag.at ? [tag.at] : []) : tag.isBehind || (tag.isFree && said.has(tag.words)) ? [] : tag.isSecond?.() ? tag.spots().slice(1) : tag.spots(); // two planes that are heavy at one angle say it once
    const put = spots.map(view.placed, view).map(([x, y]) => ({ left: x - wide / 2, top: y - high / 2 })).find(({ left, top }) => left >= 0 && top >= 0 && left + wide <= width && top + high <= height && isApart(around(left, top, wide, high)));
    made.hidden = !put;
    if (!put) return;
    said.add(tag.words);
    taken.push(around(put.left, put.top, wide, high));
    made.style.setProperty("transform", `translate(${put.left.toFixed(1)}px, ${put.top.toFixed(1)}px)`);
  });
  function around(left, top, wide, high) { return { left: frame.left + left - APART_PX, top: frame.top + top - APART_PX, right: frame.left + left + wide + APART_PX, bottom: frame.top + top + high + APART_PX }; }
}
// Of each part the first place that no metal is before.
function seen() {
  const near = 0.03 * (view.sets[view.mode]?.sphere.radius || 0), eye = view.eye();
  for (const tag of tags) {
    if (tag.kind === "part") tag.at = tag.spots(eye).find((point) => isAt(point, near)) || null;
    if (tag.isFree) tag.isBehind = before(tag.spots()[0]) > near;
  }
}
// How far the metal that is seen at a point is before it [mm], below zero behind it; null: none is seen there.
function before(point) {
  const toEye = view.eye(), rays = view.mode === "result" ? view.bodyRays : view.rays;
  const hit = rays?.cast(point.map((value, axis) => value + 1e4 * toEye[axis]), toEye.map((value) => -value), (at) => view.clip.distanceToPoint(new T.Vector3(...at)) >= 0);
  return hit ? dot(hit.point.map((value, axis) => value - point[axis]), toEye) : null;
}
function isAt(point, near) {
  const off = before(point);
  return off !== null && Math.abs(off) < near;
}
