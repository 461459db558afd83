// Digits to be read from three metres, and keys for fingers: what is read, then each of the cuts.
import { html, useEffect, useRef, useState } from "/static/preact.min.js";
import { state } from "/static/job.js";
import { shown } from "/static/tools.js";
import { Heavy, Plane, big, missing, read, recut } from "/static/machine.js";
import { kindWords } from "/static/kind-cards.js";
import { enteredFrom } from "/static/cuts.js";
import { angleText, sign, zeroWords } from "/static/zero.js";
import { unitOf } from "/static/units.js";
import { t } from "/static/words.js";

export function BigDigits() {
  const box = useRef(null), [page, setPage] = useState(0);
  useEffect(() => { if (big.value && !box.current.open) box.current.showModal(); if (!big.value && box.current.open) box.current.close(); });
  const cuts = state.result.report.corrections, at = Math.min(page, cuts.length), places = read.planes === "2" ? [1, 2] : [1];
  return html`<dialog id="big-digits" data-testid="big-digits" ref=${box} aria-label=${t("Big digits")} onClose=${() => { big.value = false; }}>${!big.value ? "" : html`
    ${at === 0 ? html`<div class="big-planes">${places.map((place) => html`<div><${Plane} place=${place} before="big-"/><${Heavy} place=${place}/></div>`)}</div>` : html`<${Cut} cut=${cuts[at - 1]} count=${cuts.length} place=${at}/>`}
    <p class="buttons"><button type="button" hidden=${at === 0} onClick=${() => setPage(at - 1)}>${t("Back")}</button><button type="button" disabled=${at >= cuts.length} onClick=${() => setPage(at + 1)}>${at === 0 ? t("The cuts") : t("Next")}</button>
    ${at === 0 ? html`<button type="button" class="main" disabled=${Object.keys(missing()).length > 0} onClick=${() => recut(false)}>${t("Plan the next cuts")}</button>` : ""}<button type="button" onClick=${() => { big.value = false; }}>${t("Close")}</button></p>`}</dialog>`;
}

function Cut({ cut, count, place }) {
  const figures = [[t("angle"), html`${angleText(cut.angle_deg)}<small class="ref"> ${sign()}</small>`], [t("depth"), `${shown(cut.depth_mm, 2, "mm")} ${unitOf("mm")}`], ["⌀", cut.diameter_mm ? `${shown(cut.diameter_mm, 2, "mm")} ${unitOf("mm")}` : "–"], ["z", `${shown(cut.z_mm, 1, "mm")} ${unitOf("mm")}`]];
  return html`<div class="big-cut"><p>${t("Cut {number}, {place} of {count}", { number: cut.number, place, count })}: ${kindWords(cut.kind)}, ${t("web")} ${cut.web ?? "–"}, ${enteredFrom(cut)}</p><dl>${figures.map(([name, value]) => html`<dt>${name}</dt><dd>${value}</dd>`)}</dl><p>${zeroWords()}</p></div>`;
}
