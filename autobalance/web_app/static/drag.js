// What other depths and angles of the cuts would leave: predicted by the server as one drags, then cut and measured.
import { $, el, predicted, shown } from "/static/tools.js";
import { askLeft, post, say } from "/static/server.js";
import { applied, state } from "/static/job.js";
import { balance } from "/static/correct.js";
import { kinds } from "/static/limits.js";

let model = null;
let run = null;
let depths = [];
let turns = [];

export function setUp() {
  $("take-depths").addEventListener("click", () => { applied(asLimits()); balance(); });
}

export async function show(id) {
  run = id;
  model = await askLeft(`/api/runs/${id}/model`);
  $("drag-box").hidden = !model?.cuts?.length;
  if ($("drag-box").hidden) return;
  depths = model.cuts.map((cut) => cut.depth_mm);
  turns = model.cuts.map(() => 0);
  $("drags").replaceChildren(...model.cuts.map(sliders));
  await predict();
}

function sliders(cut, place) {
  const made = el("fieldset", { className: "drag" }, el("legend", { textContent: `${cut.number}. ${cut.label}` }));
  const most = Math.max(cut.max_depth_mm, cut.depth_mm);
  made.append(slider(`Depth of cut ${cut.number} [mm]`, 0, most, cut.depth_step_mm || most / 400, cut.depth_mm, 2, (value) => { depths[place] = Math.min(value, most); }));
  if (cut.may_turn) made.append(slider(`Turn cut ${cut.number} about the axis [°]`, -60, 60, 0.5, 0, 1, (value) => { turns[place] = value; }));
  return made;
}

function slider(words, min, max, step, value, digits, set) {
  const input = el("input", { type: "range", min, max, step, "aria-label": words });
  input.value = value;
  const output = el("output", { textContent: shown(value, digits) });
  input.addEventListener("input", () => { set(Number(input.value)); output.textContent = shown(Number(input.value), digits); predict(); });
  return el("label", { className: "slider" }, el("span", { textContent: words.replace(/ of cut \d+| cut \d+/, "") }), output, input);
}

// One question at a time; the latest that was dragged is asked next.
let busy = false;
let again = false;
async function predict() {
  if (busy) { again = true; return; }
  busy = true;
  try {
    const found = await post(`/api/runs/${run}/predict`, { depths_mm: depths, turns_deg: turns });
    const facts = [["Residual", found.magnitude_g_mm, "g·mm", 3], ...found.planes.map((plane) => [`Plane ${plane.name}`, plane.magnitude_g_mm, "g·mm", 3]), ["Of permitted", 100 * found.worst_share, "%", 1], ["Mass", found.mass_change_g, "g", 2], ["Inertia", found.inertia_change_kg_mm2, "kg·mm²", 3]];
    $("predictions").replaceChildren(...facts.flatMap(([name, value, unit, digits]) => [el("dt", { textContent: name }), el("dd", {}, predicted(value, digits), ` ${unit}`)]));
    $("predictions").dataset.within = String(found.worst_share <= 1);
  } catch (error) { say(error.message); }
  busy = false;
  if (again) { again = false; predict(); }
}

// The depths and angles that were dragged to, as limits of the job: what the planner then keeps to.
function asLimits() {
  const changes = {};
  for (const name of new Set(model.cuts.map((cut) => cut.kind))) {
    const mine = model.cuts.flatMap((cut, place) => (cut.kind === name ? [place] : []));
    const keys = kinds.of(name).keys.map((each) => each.key);
    if (keys.includes("max_depth_mm") && mine.some((k) => depths[k] !== model.cuts[k].depth_mm)) changes[`correction.${name}.max_depth_mm`] = Math.max(...mine.map((k) => depths[k]));
    if (keys.includes("sectors_deg") && mine.some((k) => turns[k])) changes[`correction.${name}.sectors_deg`] = mine.map((k) => around(state.result.report.corrections[k].angle_deg + turns[k]));
  }
  return changes;
}
const wrapped = (angle) => Math.round(1e3 * (((angle % 360) + 360) % 360)) / 1e3;
const around = (angle) => [wrapped(angle - 1), wrapped(angle + 1)];
