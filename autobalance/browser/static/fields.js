// Fields made from declared keys: a number in the page's units, a word to choose, a list, rows of a table.
import { html, useRef } from "/static/preact.min.js";
import { listTyped, typed } from "/static/tools.js";
import { fromShown, rounded, toShown, unitOf, units } from "/static/units.js";
import { inWords, plain, t } from "/static/words.js";
import { at, changed, keep } from "/static/job.js";

const CONVERTED = ["mm", "g·mm", "kg·mm²", "mm²"];
const same = (one, other) => JSON.stringify(one) === JSON.stringify(other);
const inMetric = (value, unit) => (typeof value === "number" && CONVERTED.includes(unit) && units.value !== "metric" ? rounded(fromShown(value, unit)) : value);
const asShown = (value, unit) => (typeof value === "number" ? plain(CONVERTED.includes(unit) && units.value !== "metric" ? Number(toShown(value, unit).toPrecision(7)) : value) : String(value));

function valueOf(text, { kind, unit, key }) {
  if (text.trim() === "") return undefined;
  if (kind === "bool") return text === "true";
  if (kind === "number") return inMetric(typed(text), unit);
  if (key.endsWith("firing_order")) return text.split(/[^0-9]+/).filter((each) => each).map(Number); // 1-8-4-3-6-5-7-2
  if (kind === "list") return listTyped(text).map((each) => inMetric(each, unit));
  return text;
}
function textOf(value, { kind, unit, key }) {
  if (value === undefined || value === null) return "";
  if (Array.isArray(value)) return value.map((each) => asShown(each, unit)).join(key.endsWith("firing_order") ? "-" : "; ");
  return kind === "number" ? asShown(value, unit) : String(value);
}

// One plain value; what a person types stands as it is typed while it means what the job holds.
export function Field({ id, field, now, set, testid, label, list, help = true, wrong }) {
  const { words, unit, kind, choices = [], default: usual, says } = field, own = useRef(null), system = useRef(null);
  if (system.current !== units.value || own.current === null || !same(valueOf(own.current, field), now)) own.current = textOf(now, field);
  system.current = units.value;
  const typing = ({ target }) => { own.current = target.value; set(valueOf(target.value, field)); };
  const options = kind === "bool" ? [["true", t("yes")], ["false", t("no")]] : choices.map((each) => [each, inWords(each)]);
  const isTable = typeof now === "object" && now !== null && (!Array.isArray(now) || now.some((each) => typeof each === "object")); // in its place: in the text
  const common = { id, title: inWords(t(says || "")), "data-testid": testid, disabled: isTable, onInput: typing, "aria-describedby": [wrong ? `${id}-note` : "", says && help ? `${id}-help` : ""].filter((each) => each).join(" ") || undefined, "aria-invalid": wrong ? "true" : undefined };
  const input = options.length
    ? html`<select ...${common} value=${own.current}><option value="">${usual ? `${t("default")}: ${inWords(usual)}` : ""}</option>${options.map(([value, text]) => html`<option value=${value}>${text}</option>`)}</select>`
    : html`<input ...${common} value=${isTable ? "" : own.current} inputMode=${kind === "number" ? "decimal" : "text"} placeholder=${usual && CONVERTED.includes(unit) && Number.isFinite(Number(usual)) ? asShown(Number(usual), unit) : inWords(usual || "")} list=${list}/>`;
  return html`<label class=${options.length ? "choice" : ""}>${label || `${t(words)}${unit ? ` [${unitOf(unit)}]` : ""}`}${input}${says && help ? html`<small class="help" id=${`${id}-help`}>${inWords(t(says))}</small>` : ""}${wrong === undefined ? "" : html`<small class="note" id=${`${id}-note`}>${wrong}</small>`}</label>`;
}

// A field of the job, by its table and declaration.
export function JobField({ table, field, ...more }) {
  const path = `${table}.${field.key}`, set = (value) => { keep(path, value); changed(); };
  const id = more.id || `key-${table}-${field.key.replaceAll(".", "-")}`;
  return html`<${Any} ...${more} id=${id} field=${field} now=${at(path)} set=${set}/>`;
}

export function Any(given) {
  const kind = { rows: Rows, named: Named }[given.field.kind] || Field;
  return html`<${kind} ...${given}/>`;
}

const replaced = (list, place, value) => list.map((each, k) => (k === place ? value : each));
const without = (list, place) => list.filter((_, k) => k !== place);
export function withKey(table, path, value) {
  const [name, ...rest] = path.split("."), made = { ...table };
  const found = rest.length ? withKey(made[name] || {}, rest.join("."), value) : value;
  if (found === undefined || (rest.length && !Object.keys(found).length)) delete made[name]; else made[name] = found;
  return made;
}
export const keyOf = (table, path) => path.split(".").reduce((values, name) => values?.[name], table);

// A list of tables: a row each, with its fields.
export function Rows({ id, field, now, set }) {
  const rows = Array.isArray(now) ? now : [], name = t(field.words), kept = (next) => set(next.length ? next : undefined);
  return html`<fieldset class="rows" data-testid=${id}><legend>${name} <small>${inWords(t(field.says))}</small></legend>
    ${rows.map((row, place) => html`<div class="fields one-row" role="group" aria-label=${`${name} ${place + 1}`}>
      ${field.fields.map((each) => html`<${Any} id=${`${id}-${place + 1}-${each.key.replaceAll(".", "-")}`} field=${each} now=${keyOf(row, each.key)} set=${(value) => kept(replaced(rows, place, withKey(row, each.key, value)))} help=${false}/>`)}
      <button type="button" aria-label=${t("Remove {name}", { name: `${name} ${place + 1}` })} onClick=${() => kept(without(rows, place))}>×</button></div>`)}
    <button type="button" id=${`${id}-add`} aria-label=${`${t("Add")}: ${name}`} onClick=${() => kept([...rows, {}])}>${t("Add")}</button></fieldset>`;
}

// Values by free names: weights of parts.
export function Named({ id, field, now, set }) {
  const rows = Object.entries(now || {}), name = t(field.words);
  const kept = (next) => set(next.length ? Object.fromEntries(next) : undefined);
  const part = { key: "part", words: "name", kind: "text", unit: "" }, value = { key: "value", words: "value", kind: "number", unit: field.unit };
  const free = () => { let k = rows.length + 1; while (`part_${k}` in (now || {})) k++; return `part_${k}`; };
  return html`<fieldset class="rows" data-testid=${id}><legend>${name} <small>${inWords(t(field.says))}</small></legend>
    ${rows.map(([key, each], place) => html`<div class="fields one-row" role="group" aria-label=${`${name} ${place + 1}`}>
      <${Field} id=${`${id}-${place + 1}-name`} field=${part} now=${key} set=${(next) => next && kept(replaced(rows, place, [next, each]))}/>
      <${Field} id=${`${id}-${place + 1}-value`} field=${value} now=${each} set=${(next) => kept(replaced(rows, place, [key, next ?? 0]))}/>
      <button type="button" aria-label=${t("Remove {name}", { name: key })} onClick=${() => kept(without(rows, place))}>×</button></div>`)}
    <button type="button" id=${`${id}-add`} aria-label=${`${t("Add")}: ${name}`} onClick=${() => kept([...rows, [free(), 0]])}>${t("Add")}</button></fieldset>`;
}
