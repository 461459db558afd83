// Cuts as a hand moves them: depth, angle, drill; what they would leave is predicted by the server as one drags, then cut and measured.
import { $ } from "/static/tools.js";
import { askLeft, guarded, post, say } from "/static/server.js";
import { changed as changedJob, on, state } from "/static/job.js";
import { balance } from "/static/correct.js";
import * as handles from "/static/handles.js";
import { listed } from "/static/limits.js";
import { redraw, redrawSeen } from "/static/store.js";
import { t } from "/static/words.js";

export const TURN = 60; // degrees, each way
export const TURN_STEP = 0.5; // degrees: what a dividing head can set
// What is shown of it: the linear model of a result, where its cuts were moved to, what that is predicted to leave, what was measured.
const NOTHING = { model: null, run: null, verb: "", depths: [], turns: [], diameters: [], gripped: -1, left: null, busy: false };
export const dragged = { ...NOTHING, together: true };

export const cuts = () => dragged.model?.cuts || [];
// At another angle, or of another drill, than it was planned.
const isElsewhere = (place) => Boolean(dragged.turns[place]) || dragged.diameters[place] !== cuts()[place].diameter_mm;
export const isMoved = (place) => dragged.depths[place] !== cuts()[place].depth_mm || isElsewhere(place);
export const anyElsewhere = () => cuts().some((_, place) => isElsewhere(place));
export const anyMoved = () => cuts().some((_, place) => isMoved(place));
export const angleOf = (place) => (((state.result?.report.corrections[place]?.angle_deg ?? 0) + dragged.turns[place]) % 360 + 360) % 360;

export function setUp(view) {
  handles.setUp(view);
  document.addEventListener("keydown", (event) => {
    if (!(event.ctrlKey || event.metaKey) || $("panel-see").hidden || (/^(INPUT|TEXTAREA|SELECT)$/.test(event.target.tagName) && event.target.type !== "range")) return;
    const way = { z: event.shiftKey ? redo : undo, Z: redo, y: redo }[event.key];
    if (way?.()) event.preventDefault(); // else the job takes its own step back
  });
  on("units", () => { if (dragged.left) predict(); });
  on("selected", () => { if (isSeen() && cuts().length && !dragged.left) predict(); });
}

const isSeen = () => !$("panel-see").hidden;

// --- a result is shown, or gone -----------------------------------------------------------------------------

export function clear() {
  Object.assign(dragged, NOTHING);
  handles.show([], { cuts: [] });
  redraw();
}

export async function show(told) {
  const model = await askLeft(`/api/runs/${told.id}/model`);
  if (!model?.cuts?.length) { clear(); return model; }
  Object.assign(dragged, NOTHING, { model, run: told.id, verb: told.verb });
  Object.assign(dragged, planned());
  undone.length = redone.length = 0;
  if (isSeen()) await predict();
  return model;
}
const planned = () => ({ depths: cuts().map((cut) => cut.depth_mm), turns: cuts().map(() => 0), diameters: cuts().map((cut) => cut.diameter_mm) });

// The view has the result too: handles may stand on it.
export function grips() {
  if (cuts().length) handles.show(cuts(), { cuts: cuts(), at: (place) => ({ depth: dragged.depths[place], turn: dragged.turns[place], diameter: dragged.diameters[place] }), set, thicker, grip });
}

// --- moves --------------------------------------------------------------------------------------------------

// Cuts of other webs that the plan makes alike, and that are still where this one is.
export function alike(place) {
  const at = (k) => [cuts()[k].kind, dragged.depths[k].toFixed(3), angleOf(k).toFixed(1), dragged.diameters[k]].join();
  const webs = new Set([cuts()[place].web]);
  return cuts().flatMap((cut, k) => (k !== place && at(k) === at(place) && !webs.has(cut.web) && webs.add(cut.web) ? [k] : []));
}
export const someAlike = () => cuts().some((_, place) => alike(place).length);

const within = (value, low, high) => Math.min(Math.max(value, low), high);
function moves(place, change) {
  const places = dragged.together ? [place, ...alike(place)] : [place];
  remembered(place);
  for (const each of places) change(each, cuts()[each]);
  dragged.gripped = place;
  changed();
}
export const stepped = ({ depth_step_mm: step }, depth) => (step ? step * Math.round(depth / step) : depth);
// isExact: to the angle that somebody typed, else to one that a dividing head can set.
export function set(place, depth, turn, isExact = false) {
  moves(place, (each, cut) => {
    dragged.depths[each] = within(stepped(cut, depth), 0, handles.most(cut));
    dragged.turns[each] = cut.may_turn ? within(isExact ? turn : Math.round(turn / TURN_STEP) * TURN_STEP, -TURN, TURN) : 0;
  });
}
// A cut that somebody is about to move: its numbers are at the top of the panel.
export function grip(place) {
  if (dragged.gripped === place) return;
  dragged.gripped = place;
  redraw();
}
// Another of the shop's drills.
export const drill = (place, diameter) => moves(place, (each) => { dragged.diameters[each] = diameter; });
// The next drill of the shop: 1 thicker, -1 thinner.
function thicker(place, by) {
  const drills = cuts()[place].drills.map((each) => each.diameter_mm), now = drills.indexOf(dragged.diameters[place]);
  if (drills[now + by] !== undefined) drill(place, drills[now + by]);
}
export function asItWas() {
  remembered(-2);
  Object.assign(dragged, planned(), { gripped: -1 });
  changed();
}
function changed() {
  handles.told();
  predict(); // what is shown is busy from here on
  redrawSeen();
}

// --- undo and redo: every move, step by step ------------------------------------------------------------------

const undone = [], redone = [];
const TOGETHER_MS = 600; // moves of one cut that follow faster are one step
let last = { place: -1, at: 0 };
const now = () => ({ depths: [...dragged.depths], turns: [...dragged.turns], diameters: [...dragged.diameters] });
function remembered(place) {
  const at = performance.now();
  if (place !== last.place || at - last.at > TOGETHER_MS) { undone.push(now()); redone.length = 0; }
  last = { place, at };
}
function step(from, to) {
  if (!from.length) return false;
  to.push(now());
  Object.assign(dragged, from.pop());
  last = { place: -1, at: 0 };
  changed();
  return true;
}
export const undo = () => step(undone, redone);
export const redo = () => step(redone, undone);
export const steps = () => ({ undone: undone.length, redone: redone.length });

// --- predicted, then measured ---------------------------------------------------------------------------------

const body = () => ({ depths_mm: dragged.depths, turns_deg: dragged.turns, diameters_mm: dragged.diameters });

// One question at a time; the latest that was dragged is asked next. What is shown is busy until it is of that.
let asking = false;
let again = false;
async function predict() {
  dragged.busy = true;
  if (asking) { again = true; return; }
  asking = true;
  const { run } = dragged;
  try {
    const left = await post(`/api/runs/${run}/predict`, body());
    if (run === dragged.run) dragged.left = left;
  } catch (error) { say(error.message); }
  asking = false;
  if (again) { again = false; await predict(); return; }
  dragged.busy = false;
  redrawSeen();
}

// All cuts as they stand now go into the job, with places and depths: these are made, and measured with all papers.
export const trial = guarded(async () => {
  const numbers = cuts().flatMap((cut, place) => (isMoved(place) ? [cut.number] : []));
  listed.cuts = cuts().map((_, place) => described(place));
  changedJob();
  await balance(t("cut {numbers} moved by hand", { numbers: numbers.join(", ") }));
});

// What describes a cut of the result where it was moved to, as a job lists it: no digits that nobody can set.
const DIGITS = 4, OF_A_DIRECTION = 6;
const rounded = (value, digits) => (typeof value === "number" ? Number(value.toFixed(digits)) : Array.isArray(value) ? value.map((each) => rounded(each, digits)) : value);
const OF_ITS_PLACE = ["position_mm", "entry_mm"];
function described(place) {
  const cut = state.result.report.corrections[place], turn = dragged.turns[place];
  const known = Object.entries(cut).filter(([key, value]) => state.declared.listed.includes(key) && value !== null && !(turn && OF_ITS_PLACE.includes(key)));
  const made = { ...Object.fromEntries(known), depth_mm: dragged.depths[place] };
  if (turn) {
    made.angle_deg = angleOf(place);
    if (made.inward) made.inward = turned(made.inward, turn);
  }
  if (cut.diameter_mm !== undefined && dragged.diameters[place] !== cut.diameter_mm) made.diameter_mm = dragged.diameters[place];
  return Object.fromEntries(Object.entries(made).map(([key, value]) => [key, rounded(value, key === "inward" ? OF_A_DIRECTION : DIGITS)]));
}
function turned([x, y, z], degrees) {
  const [c, s] = [Math.cos((degrees * Math.PI) / 180), Math.sin((degrees * Math.PI) / 180)];
  return [c * x - s * y, s * x + c * y, z];
}
