// NC programs: the machine's file becomes programs of the cuts; their set-ups, and what the simulation leaves.
import { $, el, row, shown as number } from "/static/tools.js";
import { askJson, guarded, say } from "/static/server.js";
import { t } from "/static/words.js";
import { on, state } from "/static/job.js";
import { start } from "/static/runs.js";

export function setUp() {
  on("gone", () => { $("machine-ready").hidden = true; });
  on("result", ({ id }) => {
    $("machine-ready").hidden = false;
    $("recut-line").textContent = `autobalance recut runs/${id}/report.json READING.toml`;
    $("nc-line").textContent = `autobalance nc runs/${id}/report.json MACHINE.toml -o programs`;
    shown(null);
  });
  $("machine-file").addEventListener("change", guarded(async () => {
    const file = $("machine-file").files[0];
    if (file) $("machine-toml").value = await file.text();
  }));
  $("nc").addEventListener("click", programs);
  $("nc-example").addEventListener("click", guarded(() => {
    if (!state.result) throw new Error(t("balance a crank first"));
    $("machine-toml").value = example(state.result.report.corrections);
  }));
}

// A machine file to put one's own figures into: a centre with a rotary axis, and a drill for each diameter of the cuts.
function example(cuts) {
  const diameters = [...new Set(cuts.map((cut) => cut.diameter_mm).filter((each) => each))].sort((a, b) => a - b);
  const points = Object.fromEntries(cuts.map((cut) => [cut.diameter_mm, cut.point_angle_deg ?? 180]));
  const tools = diameters.map((diameter, k) => `[[tool]]\nnumber = ${k + 1}\nkind = "drill"\ndiameter_mm = ${diameter}\npoint_deg = ${points[diameter]}\nflute_mm = ${Math.max(50, Math.round(6 * diameter))}\nstick_out_mm = ${Math.max(110, Math.round(9 * diameter))}\nholder = [[32, 60], [63, 100]]\nrpm = ${Math.round(15e3 / diameter)}\nfeed_mm_min = 100\npeck_mm = 4\n`);
  return ['[machine]\npost = "linuxcnc"                # or "fanuc"\nmax_rpm = 8000\n', '[rotary]\nletter = "A"\nsign = 1\n', '[zero]\nangle = "crankpin 1"\nz_mm = "crankpin 1"\n', ...tools].join("\n");
}

const programs = guarded(async () => {
  if (!state.result) throw new Error("balance a crank first");
  if (!$("machine-toml").value.trim()) throw new Error("open or paste a machine file first; docs/nc.md has two");
  shown(null);
  const told = await start("nc", { run: state.result.id, machine: $("machine-toml").value }, "programs");
  if (!told) return;
  shown(await askJson(`/api/runs/${told.id}/report`), told.id);
  say("");
});

function shown(report, id) {
  const setups = report ? report.setups : [];
  $("setups").hidden = !setups.length;
  const link = (name, text) => el("a", { href: `/api/runs/${id}/files/${encodeURIComponent(name)}`, download: name, textContent: text });
  $("setups").tBodies[0].replaceChildren(...setups.map((each) => row([each.name, link(each.file, each.file), each.tools.map((tool) => `T${tool}`).join(", "), each.cuts.join(", "), number(each.time_s / 60, 1)], 1)));
  $("nc-left-out").replaceChildren(...(report ? report.not_programmed : []).map((each) => el("li", { textContent: `Cut ${each.correction} is not programmed: ${each.why}` })));
  if (!report) { $("nc-says").replaceChildren(); return; }
  const done = report.simulated;
  $("nc-says").replaceChildren("Simulated residual ", number(done.residual.magnitude_g_mm), " g\u00b7mm, ", number(100 * done.used_share, 0), " % of what is permitted. ", link("setup.pdf", "Set-up sheet"), " ", link("nc.json", "nc.json"));
}
