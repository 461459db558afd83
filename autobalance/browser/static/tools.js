// Small helpers: elements, numbers, tables.
import { decimal } from "/static/words.js";
import { digitsOf, toShown, unitOf, unitOfKey } from "/static/units.js";

export const $ = (id) => document.getElementById(id);

export function el(name, values = {}, ...children) {
  const made = document.createElement(name);
  for (const [key, value] of Object.entries(values)) {
    if (key === "data") Object.assign(made.dataset, value);
    else if (key.includes("-") || key === "role" || key === "for") made.setAttribute(key, value);
    else made[key] = value;
  }
  made.append(...children);
  return made;
}

// What is measured names its key in the report, by which it has its unit; what is predicted says so.
export function measured(key, value, digits = 2, unit = unitOfKey(key)) {
  if (value === null || value === undefined) return el("span", { textContent: shown(value) });
  return el("span", { textContent: shown(value, digits, unit), data: { key, value: String(value) } });
}
export function predicted(value, digits = 2, unit = "") {
  return el("span", { className: "predicted", textContent: shown(value, digits, unit), data: { predicted: String(value) } });
}
// A number in the page's units and the reader's locale; what is not known is a dash.
export const shown = (value, digits = 2, unit = "") => value === null || value === undefined ? "–" : decimal(toShown(value, unit), digitsOf(digits, unit));
export const withUnit = (value, digits, unit) => `${shown(value, digits, unit)} ${unitOf(unit)}`;

export function row(cells, head = 0) {
  const made = el("tr");
  cells.forEach((cell, place) => made.append(el(place < head ? "th" : "td", place < head ? { scope: "row" } : {}, cell)));
  return made;
}

export const ending = (name) => (name || "").toLowerCase().split(".").pop();

// Numbers as people type them: a comma is a point; what is no number stays text, for the program to refuse.
export function typed(text) {
  const plain = String(text).trim().replace(",", ".");
  return plain === "" || !Number.isFinite(Number(plain)) ? plain : Number(plain);
}
export function listTyped(text) {
  return String(text).split(/[;\s]+|,\s+/).filter((each) => each).map(typed);
}

export function debounced(work, ms) {
  let waiting = null;
  return (...given) => { clearTimeout(waiting); waiting = setTimeout(() => work(...given), ms); };
}

// Up, Down, Home and End move among the items of a list of which one can be tabbed to.
export function arrows(list, selector) {
  list.addEventListener("keydown", (event) => {
    const items = [...list.querySelectorAll(selector)], place = items.indexOf(event.target);
    const to = { ArrowDown: place + 1, ArrowUp: place - 1, Home: 0, End: items.length - 1 }[event.key];
    if (place < 0 || to === undefined || !items[to]) return;
    for (const each of items) each.tabIndex = -1;
    items[to].tabIndex = 0;
    items[to].focus();
    event.preventDefault();
  });
}
