// Unbalance across the axis: the drawing is the report page's own, asked of the server; numbers stand beside it.
import { html, useEffect, useRef } from "/static/preact.min.js";
import { askJson, behind } from "/static/server.js";
import { redrawSeen } from "/static/store.js";
import { shown, withUnit } from "/static/tools.js";
import { unitOf } from "/static/units.js";
import { angleText, sign, zeroDeg } from "/static/zero.js";
import { places } from "/static/verdict.js";
import { t } from "/static/words.js";

const MOST_KEPT = 300;
const drawings = new Map(); // what is asked for, as JSON → its drawing; empty while it is on its way
let wanted = [];
// The drawing of a polar; empty until it is here: all that are asked for at once come in one answer.
function drawing(key) {
  if (!drawings.has(key)) {
    if (drawings.size > MOST_KEPT) drawings.clear();
    drawings.set(key, "");
    wanted.push(key);
    if (wanted.length === 1) queueMicrotask(asked);
  }
  return drawings.get(key);
}
const asked = behind(async () => {
  const keys = wanted;
  wanted = [];
  try {
    const { drawn } = await askJson("/api/polars", { method: "POST", body: `{"polars": [${keys.join(",")}]}` });
    keys.forEach((key, k) => drawings.set(key, drawn[k]));
  } catch (error) {
    for (const key of keys) drawings.delete(key); // the next time that it is shown it is asked for again
    throw error;
  }
  redrawSeen();
});

// One polar with its numbers; a vector is { unbalance_g_mm, magnitude_g_mm, uncertainty_g_mm, name }, its magnitude null where nothing is known yet.
export function Polar({ title, vectors, permitted, rows, testid, within, expected }) {
  const known = vectors.filter((each) => each.magnitude_g_mm !== null), says = known.map((each) => `${t(each.name)} ${withUnit(each.magnitude_g_mm, 2, "g·mm")}`).join(", ") || t("not read yet");
  const svg = drawing(JSON.stringify({ permitted_g_mm: permitted, zero_deg: zeroDeg(), sign: sign().slice(0, -1), expected_g_mm: expected?.unbalance_g_mm || null, vectors: known.map((each) => ({ unbalance_g_mm: each.unbalance_g_mm, name: each.name, uncertainty_g_mm: each.uncertainty_g_mm ?? null })) }));
  const box = useRef(null);
  useEffect(() => { if (svg) box.current.innerHTML = svg; }, [svg]); // the server's own drawing; that of before stays until it is here
  return html`<figure class="polar" data-testid=${testid} data-within=${within} data-expected=${expected ? JSON.stringify(expected.unbalance_g_mm) : undefined}><div class="drawn" ref=${box} role="img" aria-label=${`${title}: ${says}; ${t("permitted")} ${withUnit(permitted, 2, "g·mm")}`}></div>
    <figcaption>${title}</figcaption><dl>${rows.map(([name, value, kind]) => html`<dt>${name}</dt><dd class=${kind}>${value}</dd>`)}</dl></figure>`;
}

const heavy = ({ unbalance_g_mm: [x, y], magnitude_g_mm: size }) => (size > 0 ? html`${angleText((Math.atan2(y, x) * 180) / Math.PI)}<small class="ref"> ${sign()}</small>` : "–");
const amount = (value) => shown(value, 2, "g·mm");

// Before and after of a result.
export const resultPolars = ({ initial, residual, tolerance }) => places(residual, tolerance).map(([title, after, permitted], k) => {
  const before = k ? initial.planes[k - 1] : initial, off = after.uncertainty_g_mm;
  const rows = [[t("before"), amount(before.magnitude_g_mm)], [t("heavy at"), heavy(before)], [t("after"), html`<strong>${amount(after.magnitude_g_mm)}</strong>${typeof off === "number" ? html` <span>± ${amount(off)}</span>` : ""}`, "wraps"], [t("permitted"), `${amount(permitted)} ${unitOf("g·mm")}`]];
  return html`<${Polar} title=${title} vectors=${[{ ...before, uncertainty_g_mm: null, name: "before" }, { ...after, name: "after" }]} permitted=${permitted} rows=${rows}/>`;
});
// What the crank has before any cut, predicted from its weights.
export const previewPolars = ({ initial, tolerance }) => places(initial, tolerance).map(([title, now, permitted]) => {
  const rows = [[t("now"), html`<strong class="predicted">${amount(now.magnitude_g_mm)}</strong>`], [t("heavy at"), heavy(now)], [t("permitted"), `${amount(permitted)} ${unitOf("g·mm")}`]];
  return html`<${Polar} title=${title} vectors=${[{ ...now, uncertainty_g_mm: null, name: "before" }]} permitted=${permitted} rows=${rows}/>`;
});
// What the cuts would leave where a hand has dragged them.
export const draggedPolars = ({ initial, tolerance }, left) => places(left, tolerance).map(([title, after, permitted], k) => {
  const before = k ? initial.planes[k - 1] : initial;
  const rows = [[t("before"), amount(before.magnitude_g_mm)], [t("predicted"), html`<strong class="predicted">${amount(after.magnitude_g_mm)}</strong>`], [t("heavy at"), heavy(after)], [t("permitted"), `${amount(permitted)} ${unitOf("g·mm")}`]];
  return html`<${Polar} title=${title} vectors=${[{ ...before, uncertainty_g_mm: null, name: "before" }, { ...after, uncertainty_g_mm: null, name: "after" }]} permitted=${permitted} rows=${rows}/>`;
});
