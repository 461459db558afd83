// The units of the page: what a person sees and types; the job and every report stay in mm, g and g·mm.
import { signal } from "/static/store.js";

export const SYSTEMS = { metric: "mm, g·mm", "oz-in": "inch, oz·in", "g-in": "inch, g·in" };
const KEPT = "autobalance-units";
const INCH = 25.4, OUNCE = 28.349523125, POUND = 453.59237;
// What one holds of the metric unit, its name, and how many digits more than metric it is shown with.
const LENGTHS = { mm: [INCH, "in", 1], "mm²": [INCH ** 2, "in²", 2], "kg·mm²": [(POUND / 1000) * INCH ** 2, "lb·in²", 2] };
const INCHES = { "oz-in": { ...LENGTHS, "g·mm": [OUNCE * INCH, "oz·in", 3] }, "g-in": { ...LENGTHS, "g·mm": [INCH, "g·in", 1] } };
const ENDINGS = [["_kg_mm2", "kg·mm²"], ["_g_mm", "g·mm"], ["_mm2", "mm²"], ["_mm", "mm"]];

export const units = signal(localStorage.getItem(KEPT) in SYSTEMS ? localStorage.getItem(KEPT) : "metric");
export const wasChosen = () => localStorage.getItem(KEPT) in SYSTEMS;
export function measureIn(system, keep = true) {
  if (keep) localStorage.setItem(KEPT, system);
  units.value = system;
}

const scale = (unit) => INCHES[units.value]?.[unit] || [1, unit, 0];
export const unitOf = (unit) => scale(unit)[1];
export const toShown = (value, unit) => value / scale(unit)[0];
export const fromShown = (value, unit) => value * scale(unit)[0];
export const digitsOf = (digits, unit) => digits + scale(unit)[2];
// The unit of a report's number, by its key; nothing where the page shows it as it is.
export function unitOfKey(key) {
  const name = key.split(".").find((each) => ENDINGS.some(([end]) => each.endsWith(end))) || "";
  const found = ENDINGS.find(([end]) => name.endsWith(end));
  return found ? found[1] : "";
}
// A metric number, typed in the page's units: no digits that nobody typed.
export const rounded = (value) => Number(value.toPrecision(9));
