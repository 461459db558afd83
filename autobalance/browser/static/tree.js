// What was recognised, as a tree: axis, journals, throws, webs, counterweights, faces.
import { html } from "/static/preact.min.js";
import { $ } from "/static/tools.js";
import { Measured } from "/static/measured.js";
import { redrawNow, signal } from "/static/store.js";
import { unitOf } from "/static/units.js";
import { t } from "/static/words.js";

const focused = signal(0); // the row that Tab comes to

// Figures as they are worth: four digits, no more than three decimals.
const digits = (value) => (Math.abs(value) < 1e-3 ? 0 : Math.min(3, Math.max(0, 3 - Math.floor(Math.log10(Math.abs(value))))));
const number = (of, value, unit) => html`<${Measured} of=${of} value=${value} digits=${digits(value)}/>${unit === "°" ? "" : " "}${unitOf(unit)}`;

function rowsOf({ crank, faces = [] }) {
  const rows = [["axis", 1, t("Axis"), html`${number("crank.mass_g", crank.mass_g, "g")}, ${number("crank.polar_inertia_kg_mm2", crank.polar_inertia_kg_mm2, "kg·mm²")}`, [0, 0, 0], 2]];
  crank.main_journals.forEach((pin, k) => rows.push(["main_journal", pin.number, t("Main journal {number}", pin), html`⌀<${Measured} of=${`crank.main_journals.${k}.diameter_mm`} value=${pin.diameter_mm} digits=${digits(pin.diameter_mm)}/> × ${number(`crank.main_journals.${k}.width_mm`, pin.width_mm, "mm")}`, pin.centre_mm, pin.diameter_mm / 2]));
  crank.throws.forEach((each, k) => rows.push(["throw", each.number, t("Throw {number}", each), html`${t("radius")} ${number(`crank.throws.${k}.crank_radius_mm`, each.crank_radius_mm, "mm")} ${t("at")} ${number(`crank.throws.${k}.angle_deg`, each.angle_deg, "°")}`, each.crankpin.centre_mm, each.crankpin.diameter_mm / 2]));
  crank.webs.forEach((web, k) => {
    const z = (web.z_min_mm + web.z_max_mm) / 2, radius = web.outline ? web.outline.rim_radius_mm : 20;
    rows.push(["web", web.number, t("Web {number}", web), html`z <${Measured} of=${`crank.webs.${k}.z_min_mm`} value=${web.z_min_mm} digits=${digits(web.z_min_mm)}/> ${t("to")} ${number(`crank.webs.${k}.z_max_mm`, web.z_max_mm, "mm")}`, [0, 0, z], radius]);
    if (web.counterweight) rows.push(["counterweight", web.number, t("Counterweight {number}", web), web.outline ? html`${t("rim radius")} ${number(`crank.webs.${k}.outline.rim_radius_mm`, radius, "mm")}` : "", [0, 0, z], radius]);
  });
  faces.forEach((face, k) => rows.push(["face", k + 1, t("Face {id}", face), number(`faces.${k}.area_mm2`, face.area_mm2, "mm²"), null, 0]));
  return rows;
}

export function Tree({ report, row, choose }) {
  const rows = report ? rowsOf(report) : [], at = Math.min(focused.value, Math.max(rows.length - 1, 0));
  const keys = (event, place, item) => {
    const to = { ArrowDown: place + 1, ArrowUp: place - 1, Home: 0, End: rows.length - 1 }[event.key];
    if (event.key === "Enter" || event.key === " ") choose(item);
    else if (rows[to]) { focused.value = to; redrawNow(); $("tree").children[to].focus(); }
    else return;
    event.preventDefault();
  };
  return html`<ul role="tree" data-testid="tree" id="tree" aria-label=${t("Recognised features")}>${rows.map(([kind, count, name, says, centre, radius], place) => {
    const item = { row: `${kind} ${count}`, kind, number: count, centre, radius };
    return html`<li key=${item.row} role="treeitem" tabindex=${place === at ? 0 : -1} aria-level=${kind === "axis" ? 1 : kind === "face" ? 3 : 2} aria-selected=${String(row === item.row)} data-kind=${kind} data-number=${String(count)} onClick=${() => { focused.value = place; choose(item); }} onKeyDown=${(event) => keys(event, place, item)}>${name} <span>${says}</span></li>`;
  })}</ul>`;
}
