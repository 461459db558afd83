// Unbalance across the axis: the permitted circle has the same size everywhere, the job's zero is up, angles go counter-clockwise.
import { html } from "/static/preact.min.js";
import { shown, withUnit } from "/static/tools.js";
import { unitOf } from "/static/units.js";
import { angleText, sign, zeroDeg } from "/static/zero.js";
import { t } from "/static/words.js";

export const PERMITTED = 44, RIM = 66; // radii on the drawing, of 200
const MIDDLE = 100;
const MARKS = [[90, 14, 105], [180, MIDDLE, 192], [270, 186, 105]];

// One polar with its numbers; a vector is { unbalance_g_mm, magnitude_g_mm, uncertainty_g_mm, name }, its magnitude null where nothing is known yet.
export function Polar({ title, vectors, permitted, rows, testid, within, expected }) {
  const known = vectors.filter((each) => each.magnitude_g_mm !== null), says = known.map((each) => `${t(each.name)} ${withUnit(each.magnitude_g_mm, 2, "g·mm")}`).join(", ") || t("not read yet");
  return html`<figure class="polar" data-testid=${testid} data-within=${within}><svg viewBox="0 0 200 200" role="img" aria-label=${`${title}: ${says}; ${t("permitted")} ${withUnit(permitted, 2, "g·mm")}`}>
    <circle class="p-ring" cx=${MIDDLE} cy=${MIDDLE} r=${RIM}/><path class="p-axis" d=${`M${MIDDLE} ${MIDDLE - RIM}v${2 * RIM}M${MIDDLE - RIM} ${MIDDLE}h${2 * RIM}`}/><circle class="p-ok permitted" cx=${MIDDLE} cy=${MIDDLE} r=${PERMITTED}/>
    <text class="p-lab p-zero" x=${MIDDLE} y="22" text-anchor="middle">0° ${sign().slice(0, -1)}</text>${MARKS.map(([degrees, x, y]) => html`<text class="p-lab" x=${x} y=${y} text-anchor="middle">${degrees}</text>`)}
    ${expected ? html`<${Expected} from=${expected} to=${known[0]} per=${PERMITTED / permitted}/>` : ""}${known.map((each) => html`<${Arrow} ...${each} per=${PERMITTED / permitted}/>`)}</svg>
    <figcaption>${title}</figcaption><dl>${rows.map(([name, value]) => html`<dt>${name}</dt><dd>${value}</dd>`)}</dl></figure>`;
}

// What was expected: a ring, and the path from it to what is read.
function Expected({ from, to, per }) {
  const turn = (zeroDeg() * Math.PI) / 180, place = ({ unbalance_g_mm: [x, y] }) => {
    const angle = Math.atan2(y, x) - turn, length = Math.min(per * Math.hypot(x, y), RIM);
    return [MIDDLE - length * Math.sin(angle), MIDDLE - length * Math.cos(angle)].map((each) => each.toFixed(2));
  };
  const [x, y] = place(from);
  return html`<g class="expected" data-expected=${JSON.stringify(from.unbalance_g_mm)}>${to ? html`<path class="p-path" d=${`M${x} ${y}L${place(to).join(" ")}`}/>` : ""}<circle class="p-expected" cx=${x} cy=${y} r="4"/></g>`;
}

// What does not fit ends at the rim, with a break mark across it.
function Arrow({ unbalance_g_mm: [along, across], magnitude_g_mm: size, uncertainty_g_mm: off, name, per }) {
  const turn = (zeroDeg() * Math.PI) / 180, angle = Math.atan2(across, along) - turn, length = Math.min(per * size, RIM), isCut = per * size > RIM;
  const at = (radius, aside = 0) => `${(MIDDLE - radius * Math.sin(angle) - aside * Math.cos(angle)).toFixed(2)} ${(MIDDLE - radius * Math.cos(angle) + aside * Math.sin(angle)).toFixed(2)}`;
  const [x, y] = at(length).split(" "), kind = name === "before" ? "p-before" : "p-after";
  return html`<g>${off && !isCut ? html`<circle class="p-unc" cx=${x} cy=${y} r=${Math.min(per * off, RIM)}/>` : ""}<path class=${kind} d=${`M${MIDDLE} ${MIDDLE}L${at(length)}${isCut ? `M${at(length - 8, 6)}L${at(length - 3, -6)}M${at(length - 14, 6)}L${at(length - 9, -6)}` : ""}`}/><circle class=${`${kind} tip ${name}`} cx=${x} cy=${y} r="4.5"/></g>`;
}

const heavy = ({ unbalance_g_mm: [x, y], magnitude_g_mm: size }) => (size > 0 ? html`${angleText((Math.atan2(y, x) * 180) / Math.PI)}<small class="ref"> ${sign()}</small>` : "–");
const amount = (value) => shown(value, 2, "g·mm");
const places = (what, tolerance) => [[t("Resultant"), what, tolerance.permissible_g_mm], ...what.planes.map((plane, k) => [`${t("Plane")} ${plane.name}`, plane, tolerance.planes[k].permissible_g_mm])];

// Before and after of a result.
export const resultPolars = ({ initial, residual, tolerance }) => places(residual, tolerance).map(([title, after, permitted], k) => {
  const before = k ? initial.planes[k - 1] : initial, off = after.uncertainty_g_mm;
  const rows = [[t("before"), amount(before.magnitude_g_mm)], [t("heavy at"), heavy(before)], [t("after"), html`<strong>${amount(after.magnitude_g_mm)}</strong>${typeof off === "number" ? ` ± ${amount(off)}` : ""}`], [t("permitted"), `${amount(permitted)} ${unitOf("g·mm")}`]];
  return html`<${Polar} title=${title} vectors=${[{ ...before, uncertainty_g_mm: null, name: "before" }, { ...after, name: "after" }]} permitted=${permitted} rows=${rows}/>`;
});
// What the crank has before any cut, predicted from its weights.
export const previewPolars = ({ initial, tolerance }) => places(initial, tolerance).map(([title, now, permitted]) => {
  const rows = [[t("now"), html`<strong class="predicted">${amount(now.magnitude_g_mm)}</strong>`], [t("heavy at"), heavy(now)], [t("permitted"), `${amount(permitted)} ${unitOf("g·mm")}`]];
  return html`<${Polar} title=${title} vectors=${[{ ...now, uncertainty_g_mm: null, name: "before" }]} permitted=${permitted} rows=${rows}/>`;
});
