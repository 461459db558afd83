// Machine: what a balancing machine read becomes the next cuts; every stage with its files.
import { $, el, listTyped, measured, row, typed } from "/static/tools.js";
import { askJson, guarded, say } from "/static/server.js";
import { emit, on, state } from "/static/job.js";
import { start } from "/static/runs.js";

let trusted = false;

export function setUp() {
  on("result", shown);
  on("begun", () => { trusted = false; });
  $("reading-planes").addEventListener("input", () => { $("plane-2").hidden = $("reading-planes").value === "1"; });
  $("recut").addEventListener("click", () => recut(false));
  $("trust").addEventListener("click", () => recut(true));
}

function shown({ id, report }) {
  $("machine-ready").hidden = false;
  $("machine-none").hidden = true;
  const bobs = report.engine.bob_weights;
  $("bob-weights").placeholder = bobs.map((each) => (each.fit_g ?? each.mass_g).toFixed(2)).join("; ");
  $("bob-card").replaceChildren(...bobs.flatMap((each, k) => [el("span", {}, `Throw ${each.throw}: clamp on `, measured(`engine.bob_weights.${k}.fit_g`, each.fit_g), ` g, ± `, measured(`engine.bob_weights.${k}.tolerance_g`, each.tolerance_g, 2), " g. ")]));
  const names = report.tolerance.planes.map((plane) => plane.name);
  for (const number of [1, 2]) if (names[number - 1]) $(`at-${number}`).value = names[number - 1];
  if (names.length < 2) { $("reading-planes").value = "1"; $("plane-2").hidden = true; }
  $("recut-line").textContent = `autobalance recut runs/${id}/report.json READING.toml`;
  $("suspects").replaceChildren();
  $("trust").hidden = true;
  guarded(stages)(report.stages || [], id);
}

function plane(number) {
  const at = $(`at-${number}`).value.trim();
  const place = /^[AB]$/i.test(at) ? { at: at.toUpperCase() } : at === "" ? {} : { z_mm: typed(at) };
  return { ...place, g_mm: typed($(`g-mm-${number}`).value), angle_deg: typed($(`angle-${number}`).value) };
}

function reading() {
  const two = $("reading-planes").value === "2";
  const made = { urr_percent: typed($("urr").value), umar_g_mm: typed($("umar").value), rotation: $("rotation").value, reads: $("reads").value, zero_deg: typed($("zero").value || "0"), plane: two ? [plane(1), plane(2)] : [plane(1)] };
  if ($("reading-speed").value.trim()) made.speed_rpm = typed($("reading-speed").value);
  if ($("serial").value.trim()) made.serial = $("serial").value.trim();
  if ($("bob-weights").value.trim()) made.bob_weights_g = listTyped($("bob-weights").value);
  return made;
}

const recut = guarded(async (trust) => {
  if (!state.result) throw new Error("balance a crank first");
  const run = state.result.id;
  trusted = trust;
  $("suspects").replaceChildren();
  $("trust").hidden = true;
  try {
    const told = await start("recut", { run, reading: reading(), trust_reading: trusted }, "from a reading");
    if (told) { emit("show", told); say(""); }
  } catch (error) {
    say(error.message);
    if (!error.message.includes("--trust-reading")) return;
    $("suspects").replaceChildren(el("li", { textContent: error.message.replace("; --trust-reading goes on", "") }));
    $("trust").hidden = false;
  }
});

async function stages(list, id) {
  const { runs } = await askJson("/api/runs");
  $("stages").hidden = !list.length;
  const amount = (k, key, values) => (values ? measured(`stages.${k}.${key}.magnitude_g_mm`, values.magnitude_g_mm) : "–");
  $("stages").tBodies[0].replaceChildren(...list.map((stage, k) => {
    const last = k === list.length - 1;
    const own = last ? id : stage.report.split("/").slice(-2)[0];
    const links = el("span", {}, el("a", { href: `/api/runs/${own}/files/report.json`, download: `stage-${stage.stage}.json`, textContent: "report" }), " ");
    const solid = runs.find((each) => each.id === own)?.files.find((name) => name.startsWith("balanced."));
    if (solid) links.append(el("a", { href: `/api/runs/${own}/files/${encodeURIComponent(solid)}`, download: `stage-${stage.stage}-${solid}`, textContent: "solid" }));
    return row([String(stage.stage), amount(k, "reading", stage.reading), amount(k, "expected", stage.expected), String(stage.corrections), amount(k, "predicted", stage.predicted), links], 1);
  }));
  const found = list.flatMap((stage, k) => stage.suspects.map((each, place) => {
    const amount = (key) => measured(`stages.${k}.suspects.${place}.${key}`, each[key], 1);
    return el("li", {}, `Stage ${stage.stage}: ${each.key}: ${each.says} (`, amount("difference_g_mm"), " g·mm apart, ", amount("left_g_mm"), " left)");
  }));
  const warned = state.result?.report.command === "recut" ? state.result.report.warnings : [];
  $("suspects").replaceChildren(...found, ...warned.map((text) => el("li", { textContent: text })));
}
