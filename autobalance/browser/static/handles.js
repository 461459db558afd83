// Handles on the cuts in the model: dragged along a cut for its depth, across it for its angle; or by keys.
import { $, el, shown, withUnit } from "/static/tools.js";
import { cutWords } from "/static/cuts.js";
import { t } from "/static/words.js";

const GRIPPED = 4; // px before a drag has a direction
const SLICE_MS = 20; // of a frame, for finding out which numbers metal hides
const CLEAR_MM = 0.3; // out of the metal, where it is asked whether a cut is seen
const STEEP = 0.25; // share of its length that a depth must show on the screen to be dragged along

let view = null;
let hands = [];
let given = null; // { cuts, at(place) → { depth, turn, diameter }, set(place, depth, turn), thicker(place, by), grip(place) }

export function setUp(model) {
  view = model;
  view.ondrawn = follow;
}

const rad = (deg) => (deg * Math.PI) / 180;
const about = ([x, y, z], deg) => { const c = Math.cos(rad(deg)), s = Math.sin(rad(deg)); return [c * x - s * y, s * x + c * y, z]; };
export const most = (cut) => Math.max(cut.max_depth_mm, cut.depth_mm);

// One handle a cut; `asked` tells and takes what is dragged.
export function show(cuts, asked) {
  given = asked;
  hiding++;
  hands = cuts.map((cut, place) => {
    const made = el("div", { tabIndex: 0, className: "handle", role: "slider", textContent: String(cut.number), "aria-valuemin": "0", "aria-valuemax": most(cut).toFixed(3), "aria-label": [`${t("Cut {number}", cut)}, ${cutWords(cut)}: ${t("depth")} [mm]`, cut.may_turn ? t("left and right turn it about the axis") : "", cut.drills.length > 1 ? t("brackets choose the drill") : ""].filter(Boolean).join("; "), data: { testid: "handle", cut: String(cut.number) } });
    made.addEventListener("pointerdown", (event) => grip(event, made, cut, place));
    made.addEventListener("focus", () => given.grip(place));
    made.addEventListener("keydown", (event) => keyed(event, cut, place));
    if (cut.drills.length > 1) made.addEventListener("wheel", (event) => { event.preventDefault(); given.thicker(place, event.deltaY < 0 ? 1 : -1); }, { passive: false });
    return made;
  });
  $("handles").replaceChildren(...hands);
  told();
}

// The middle of a cut's floor, as it is dragged.
function floor(cut, depth, turn) {
  return about(cut.begin_mm.map((value, axis) => value + depth * cut.deeper[axis]), turn);
}

// Put every handle where its cut is on the screen.
function follow() {
  $("handles").hidden = view.mode !== "result" || !hands.length || $("panel-see").hidden;
  $("dragged-root").dataset.away = String($("handles").hidden);
  if ($("handles").hidden) return;
  const width = $("handles").clientWidth, height = $("handles").clientHeight, wide = (hands[0]?.offsetWidth || 0) + 2; // read before anything moves
  const at = hands.map((hand, place) => {
    const cut = given.cuts[place], { depth, turn } = given.at(place);
    const [x, y, near] = view.placed(floor(cut, depth, turn));
    hand.style.setProperty("z-index", String(Math.round(500 * (1 + near))));
    hand.hidden = x < 0 || y < 0 || x > width || y > height;
    return { hand, x, y, near };
  });
  for (const { hand, x, y } of apart(at, wide)) {
    hand.style.setProperty("left", `${x.toFixed(1)}px`);
    hand.style.setProperty("top", `${y.toFixed(1)}px`);
  }
  if (!view.turning) hide();
}

// Numbers beside one another: one that would lie over a nearer one goes aside; those that metal hides take no room.
const TRIES = 12;
function apart(at, wide) {
  const put = [];
  const isSeen = ({ hand }) => !hand.hidden && hand.dataset.behind !== "true";
  for (const each of [...at].sort((one, other) => other.near - one.near)) {
    for (let k = 0; isSeen(each) && k < TRIES; k++) {
      const other = put.find((one) => Math.abs(one.x - each.x) < wide && Math.abs(one.y - each.y) < wide);
      if (!other) break;
      const sideways = Math.abs(each.x - other.x) >= Math.abs(each.y - other.y);
      if (sideways) each.x = other.x + (each.x < other.x ? -wide : wide);
      else each.y = other.y + (each.y < other.y ? -wide : wide);
    }
    if (isSeen(each)) put.push(each);
  }
  return at;
}

// Hide the numbers that metal is before, some at a time: three rays a cut through a large crank take long.
let hiding = 0, shifted = false;
function hide(place = 0, mine = ++hiding) {
  if (mine !== hiding || view.turning) return;
  const until = performance.now() + SLICE_MS;
  for (; place < hands.length && performance.now() < until; place++) {
    const { depth, turn } = given.at(place), at = [-CLEAR_MM, depth - CLEAR_MM, depth + CLEAR_MM]; // of two at a face, one is in metal
    const behind = String(!at.some((deep) => view.sees(floor(given.cuts[place], deep, turn))));
    if (hands[place].dataset.behind !== behind) { hands[place].dataset.behind = behind; shifted = true; }
  }
  if (place >= hands.length && shifted) { shifted = false; follow(); }
  if (place < hands.length) requestAnimationFrame(() => hide(place, mine));
}

// Tell each handle's value, and move the metal that it holds.
export function told() {
  hands.forEach((hand, place) => {
    const cut = given.cuts[place], { depth, turn, diameter } = given.at(place);
    hand.setAttribute("aria-valuenow", depth.toFixed(3));
    hand.setAttribute("aria-valuetext", `${withUnit(depth, 2, "mm")} ${t("deep")}${cut.drills.length > 1 ? `, ⌀ ${withUnit(diameter, 2, "mm")}` : ""}${cut.may_turn ? `, ${t("turned")} ${shown(turn, 1)}°` : ""}`);
    hand.title = hand.getAttribute("aria-valuetext");
    const scale = cut.rim_mm === null ? null : (cut.rim_mm - depth) / (cut.rim_mm - cut.depth_mm);
    const wide = diameter && cut.diameter_mm ? diameter / cut.diameter_mm : 1;
    view.moved(cut.number, { by: depth - cut.depth_mm, way: cut.deeper, turn: rad(turn), scale, wide, middle: floor(cut, cut.depth_mm, 0) });
  });
}

// --- a hand on a handle -----------------------------------------------------------------------------------

function grip(down, hand, cut, place) {
  if (down.button !== 0) return;
  down.preventDefault();
  hand.focus({ preventScroll: true });
  hand.setPointerCapture(down.pointerId);
  const start = given.at(place), ways = directions(cut, start);
  let along = null;
  const move = (event) => {
    const d = [event.clientX - down.clientX, event.clientY - down.clientY];
    if (!along && Math.hypot(...d) >= GRIPPED) along = ways.turn && share(d, ways.turn) > share(d, ways.depth) ? ways.turn : ways.depth;
    if (!along) return;
    view.held = true;
    const [wx, wy] = along, by = (d[0] * wx + d[1] * wy) / (wx * wx + wy * wy);
    if (along === ways.depth) given.set(place, start.depth + by, start.turn);
    else given.set(place, start.depth, start.turn + by);
  };
  const end = () => { view.held = false; if (view.turning) view.restSoon(); for (const [name, work] of [["pointermove", move], ["pointerup", end], ["pointercancel", end]]) hand.removeEventListener(name, work); };
  for (const [name, work] of [["pointermove", move], ["pointerup", end], ["pointercancel", end]]) hand.addEventListener(name, work);
}
const share = ([x, y], [wx, wy]) => Math.abs(x * wx + y * wy) / (Math.hypot(wx, wy) || 1);

// What a millimetre of depth, and a degree about the axis, are on the screen [px].
function directions(cut, { depth, turn }) {
  const from = view.placed(floor(cut, depth, turn));
  const to = (point) => { const at = view.placed(point); return [at[0] - from[0], at[1] - from[1]]; };
  const scale = (view.box.clientHeight * view.camera.zoom) / (view.camera.top - view.camera.bottom);
  let way = to(floor(cut, depth + 1, turn));
  if (Math.hypot(...way) < STEEP * scale) way = [0, scale]; // it points at the eye: down is deeper then
  return { depth: way, turn: cut.may_turn ? to(floor(cut, depth, turn + 1)) : null };
}

function keyed(event, cut, place) {
  const { depth, turn } = given.at(place), step = cut.depth_step_mm || most(cut) / 100;
  const deeper = { ArrowUp: step, ArrowDown: -step, PageUp: 10 * step, PageDown: -10 * step }[event.key];
  const across = { ArrowRight: 1, ArrowLeft: -1 }[event.key], thicker = { "]": 1, "[": -1 }[event.key];
  if (deeper) given.set(place, depth + deeper, turn);
  else if (across && cut.may_turn) given.set(place, depth, turn + across);
  else if (across) given.set(place, depth + across * step, turn);
  else if (thicker) given.thicker(place, thicker);
  else if (event.key === "Home") given.set(place, 0, turn);
  else if (event.key === "End") given.set(place, most(cut), turn);
  else if (event.key === "Escape") { given.set(place, cut.depth_mm, 0); given.grip(-1); }
  else return;
  event.preventDefault();
}
