// Unbalance as arrows across the axis, with the circle of the permissible one: the job's zero up, angles counter-clockwise.
import { html, render } from "/static/preact.min.js";
import { withUnit } from "/static/tools.js";
import { sign, zeroDeg } from "/static/zero.js";
import { t } from "/static/words.js";

const RADIUS = 70, MIDDLE = 100;
const ANGLES = [[0, MIDDLE, 22], [90, 14, 104], [180, MIDDLE, 186], [270, 184, 104]];

// Plots of [title, vectors, permitted]: one for each vector, in the scale that shows both it and the permissible unbalance.
export const Polars = ({ plots }) => plots.map(([title, vectors, permitted]) => html`<figure><figcaption>${title}</figcaption><div class="pair">${vectors.map((each) => html`<${Polar} title=${title} vector=${each} permitted=${permitted}/>`)}</div></figure>`);
export const drawn = (box, plots) => render(html`<${Polars} plots=${plots}/>`, box);

export function Polar({ title, vector, permitted }) {
  const { unbalance_g_mm: [along, across], magnitude_g_mm: size, name } = vector;
  const turn = (zeroDeg() * Math.PI) / 180, xy = [along * Math.cos(turn) + across * Math.sin(turn), across * Math.cos(turn) - along * Math.sin(turn)];
  const per = RADIUS / Math.max(size || 0, 1.05 * permitted, 1e-9), x = (MIDDLE - per * xy[1]).toFixed(2), y = (MIDDLE - per * xy[0]).toFixed(2);
  const says = size === null ? t("not read yet") : `${t(name)} ${withUnit(size, 2, "g·mm")}`;
  return html`<svg viewBox="0 0 200 206" role="img" aria-label=${`${title}: ${says}; ${t("permitted")} ${withUnit(permitted, 2, "g·mm")}`}>
    <circle class="grid" cx=${MIDDLE} cy=${MIDDLE} r=${RADIUS}/><path class="grid" d=${`M${MIDDLE} ${MIDDLE - RADIUS}v${2 * RADIUS}M${MIDDLE - RADIUS} ${MIDDLE}h${2 * RADIUS}`}/>
    <circle class="permitted" cx=${MIDDLE} cy=${MIDDLE} r=${Math.max(1, per * permitted)}/>
    ${ANGLES.map(([degrees, left, top]) => html`<text x=${left} y=${top} text-anchor="middle">${degrees}°${degrees === 0 ? ` ${sign()}` : ""}</text>`)}
    ${size === null ? "" : html`<path class=${`vector ${name}`} d=${`M${MIDDLE} ${MIDDLE}L${x} ${y}`}/><circle class=${`tip ${name}`} cx=${x} cy=${y} r="4"/>`}
    <text class="when" x=${MIDDLE} y="203" text-anchor="middle">${says}</text></svg>`;
}
