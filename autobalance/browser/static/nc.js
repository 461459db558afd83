// NC programs: the machine's file becomes programs of the cuts; their set-ups, and what the simulation leaves.
import { html } from "/static/preact.min.js";
import { $, shown, withUnit } from "/static/tools.js";
import { askJson, guarded, say } from "/static/server.js";
import { on, state } from "/static/job.js";
import { start } from "/static/runs.js";
import { mount, signal } from "/static/store.js";
import { said } from "/static/said.js";
import { t } from "/static/words.js";

const machine = signal(""); // the text of the machine file
const done = signal(null); // { id, report } of the programs that were written

export function setUp() {
  mount(Ready, $("machine-ready"));
  for (const name of ["gone", "result"]) on(name, () => { done.value = null; });
}

// A machine file to put one's own figures into: a centre with a rotary axis, and a drill for each diameter of the cuts.
function example(cuts) {
  const diameters = [...new Set(cuts.map((cut) => cut.diameter_mm).filter((each) => each))].sort((a, b) => a - b);
  const points = Object.fromEntries(cuts.map((cut) => [cut.diameter_mm, cut.point_angle_deg ?? 180]));
  const tools = diameters.map((diameter, k) => `[[tool]]\nnumber = ${k + 1}\nkind = "drill"\ndiameter_mm = ${diameter}\npoint_deg = ${points[diameter]}\nflute_mm = ${Math.max(50, Math.round(6 * diameter))}\nstick_out_mm = ${Math.max(110, Math.round(9 * diameter))}\nholder = [[32, 60], [63, 100]]\nrpm = ${Math.round(15e3 / diameter)}\nfeed_mm_min = 100\npeck_mm = 4\n`);
  return ['[machine]\npost = "linuxcnc"                # or "fanuc"\nmax_rpm = 8000\n', '[rotary]\nletter = "A"\nsign = 1\n', '[zero]\nangle = "crankpin 1"\nz_mm = "crankpin 1"\n', ...tools].join("\n");
}

const programs = guarded(async () => {
  if (!machine.value.trim()) throw new Error(t("open or paste a machine file first; docs/nc.md has two"));
  done.value = null;
  const told = await start("nc", { run: state.result.id, machine: machine.value }, "programs");
  if (!told) return;
  done.value = { id: told.id, report: await askJson(`/api/runs/${told.id}/report`) };
  say("");
});
const opened = guarded(async ({ target }) => { if (target.files[0]) machine.value = await target.files[0].text(); });

function Ready() {
  if (!state.result) return "";
  const folder = `runs/${state.result.id}/report.json`;
  return html`<p class="quiet">${t("The same from the command line:")}</p><pre id="recut-line" tabindex="0">autobalance recut ${folder} READING.toml</pre>
    <details id="nc-box"><summary>${t("NC programs")}</summary><p class="quiet">${t("Open or paste the machine's file: machine, rotary axis, zero and tools. Or begin with an example, and put the figures of your machine in.")}</p>
    <p class="buttons"><button type="button" id="nc-example" data-testid="nc-example" onClick=${() => { machine.value = example(state.result.report.corrections); }}>${t("Begin with an example")}</button></p>
    <p><label>${t("Machine file")} <input type="file" id="machine-file" data-testid="machine-file" accept=".toml" onChange=${opened}/></label></p>
    <label for="machine-toml">${t("Text of the machine file")}</label><textarea id="machine-toml" data-testid="machine-toml" rows="8" spellcheck=${false} value=${machine.value} onInput=${({ target }) => { machine.value = target.value; }}></textarea>
    <p class="buttons"><button type="button" id="nc" data-testid="nc" onClick=${programs}>${t("Write NC programs")}</button></p><${Programs}/>
    <p class="quiet">${t("Simulated from the text of the programs, not proven on a machine. The same from the command line:")}</p><pre id="nc-line" tabindex="0">autobalance nc ${folder} MACHINE.toml -o programs</pre></details>`;
}

function Programs() {
  const { id, report } = done.value || {}, setups = report?.setups || [], left = report?.not_programmed || [], simulated = report?.simulated;
  const link = (name, text) => html`<a href=${`/api/runs/${id}/files/${encodeURIComponent(name)}`} download=${name}>${text}</a>`;
  return html`<p id="nc-says" data-testid="nc-says" aria-live="polite">${report ? html`${t("Simulated residual")} ${withUnit(simulated.residual.magnitude_g_mm, 2, "g·mm")}, ${t("{share} % of the permissible unbalance", { share: shown(100 * simulated.used_share, 0) })}. ${link("setup.pdf", t("Set-up sheet"))} ${link("nc.json", "nc.json")}` : ""}</p>
    <table id="setups" data-testid="setups" hidden=${!setups.length}><caption>${t("Set-ups, in their order")}</caption><thead><tr>${["set-up", "program", "tools", "cuts", "time [min]"].map((words) => html`<th scope="col">${t(words)}</th>`)}</tr></thead>
    <tbody>${setups.map((each) => html`<tr><th scope="row">${each.name}</th><td>${link(each.file, each.file)}</td><td>${each.tools.map((tool) => `T${tool}`).join(", ")}</td><td>${each.cuts.join(", ")}</td><td>${shown(each.time_s / 60, 1)}</td></tr>`)}</tbody></table>
    <ul id="nc-left-out" aria-label=${t("Cuts that are not programmed")}>${left.map((each) => html`<li>${t("Cut {number} is not programmed: {why}", { number: each.correction, why: said(each.why) })}</li>`)}</ul>`;
}
