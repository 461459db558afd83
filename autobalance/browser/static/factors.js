// Balance factors to choose from, as the command `factor` finds them: the forces that each leaves, and what reaching it takes.
import { html } from "/static/preact.min.js";
import { shown } from "/static/tools.js";
import { askJson, guarded } from "/static/server.js";
import { answered, changed, job, keep, on } from "/static/job.js";
import { running, start, watched } from "/static/runs.js";
import { signal } from "/static/store.js";
import { t } from "/static/words.js";

const found = signal(null); // { id, job, rows } of the run that is shown
const NAMES = { present: "today", "maker's": "the maker's", half: "half", least_peak: "smallest force", given: "wanted" };
const asked = () => { const { engine, original, balance, correction } = job(); return JSON.stringify([engine, original, balance?.grade, balance?.speed_rpm, correction]); };

on("forgotten", () => { found.value = null; });
const compare = guarded(async () => {
  answered();
  const of = asked(), told = await watched(() => start("factor", { job: job() }, t("balance factors")));
  if (told) found.value = { id: told.id, of, rows: (await askJson(`/api/runs/${told.id}/report`)).candidates };
});
const take = (row) => { keep("balance.factor", row.name === "maker's" ? "original" : Math.round(1e4 * row.factor) / 1e4); changed(); };

export function Factors() {
  const isGoing = running().some((told) => told.verb === "factor"), rows = found.value?.rows || [], isOld = found.value && found.value.of !== asked();
  const cost = ({ reach }) => (!reach ? "–" : reach.outcome === "above_tolerance" ? t("not reached") : reach.cuts ? `${reach.cuts} / ${shown(reach.metal_g, 1)} g` : t("nothing"));
  return html`<p class="buttons"><button type="button" class="small" id="compare-factors" data-testid="compare-factors" disabled=${isGoing} onClick=${compare}>${isGoing ? t("Comparing …") : t("Compare factors")}</button></p>
    <table id="factors" data-testid="factors" hidden=${!rows.length} data-old=${String(Boolean(isOld))}><caption>${isOld ? t("From an earlier job; compare again") : t("Force and cuts of each factor")}</caption>
      <thead><tr><th scope="col">${t("factor")}</th><th scope="col"></th><th scope="col">${t("force")} [N]</th><th scope="col">${t("cuts, metal")}</th><td></td></tr></thead>
      <tbody>${rows.map((row) => html`<tr data-name=${row.name}><td>${t(NAMES[row.name])}</td><td class="num" data-factor=${String(row.factor)}>${shown(row.factor, 3)}</td><td class="num" data-force=${String(row.greatest_N)}>${shown(row.greatest_N, 0)}</td><td class="num">${cost(row)}</td><td>${row.factor >= 0 && row.factor <= 1 ? html`<button type="button" class="small" aria-label=${t("Take {name}", { name: shown(row.factor, 3) })} onClick=${() => take(row)}>${t("Take")}</button>` : ""}</td></tr>`)}</tbody></table>`;
}
