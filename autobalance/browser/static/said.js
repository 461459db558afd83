// Messages of the program in the words of the page: labels of fields in place of keys, tables and options.
import { GROUPS, state } from "/static/job.js";
import { kinds } from "/static/limits.js";
import { sayIn } from "/static/server.js";
import { inWords, t } from "/static/words.js";

// Keys of a reading, whose fields no table declares, and tables that are columns or folds of the page.
const OF_READINGS = { rotation: "Angles increase", reads: "The machine shows", zero_deg: "Machine zero at", at: "at A, B or z [mm]", g_mm: "Unbalance", bob_weights_g: "Bob-weights fitted [g]", umar_g_mm: "Minimum achievable residual Umar", urr_percent: "Unbalance reduction ratio URR" };
const TABLES = { original: "the weights before", correction: "Correction method" };
const capital = (words) => words.charAt(0).toLocaleUpperCase() + words.slice(1);
const named = (key) => inWords(key).replace(/\[(\d+)\]/g, " $1");
const isTable = (name) => Boolean(name in TABLES || state.declared?.tables.some(({ table }) => table === name) || kinds.of(name));

// The field of a key: by its path, else by its own name in any table or kind; null where the page has none.
function fieldOf(path) {
  const [table, ...rest] = path.replace(/\[\d+\]/g, "").split("."), all = state.declared?.tables || [];
  const kind = kinds.of(table === "correction" ? rest[0] : table), key = (table === "correction" && kind ? rest.slice(1) : rest).join(".");
  if (rest.length) return (kind ? kind.keys : all.find((each) => each.table === table)?.keys || []).find((each) => each.key === key) || null;
  return [...kinds.list, ...all].flatMap(({ keys }) => keys).find((each) => each.key.split(".").at(-1) === path) || null;
}
// What a person calls a key of the job: its field's label.
export function labelOf(path) {
  if (path === "correction.method") return t("Correction method");
  const [table, ...rest] = path.split(".");
  if (table === "original" && rest.length) return `${capital(named(rest.at(-1)))} (${t("before")})`;
  const field = fieldOf(path), last = rest.at(-1) || table, above = rest.at(-2);
  if (!field && above && !(above in GROUPS)) return capital(`${named(above)}, ${named(last)}`); // of a row or a part
  return capital(field ? t(field.words) : t(OF_READINGS[last] || named(last)));
}
const valueOf = (text) => ({ true: t("yes"), false: t("no") })[text] || (/^"/.test(text) ? t(inWords(text.slice(1, -1))) : text);
const isKnown = (path) => Boolean(fieldOf(path) || path in OF_READINGS || (path.includes(".") && isTable(path.split(".")[0])));

const SET = /--set '?([\w.]+)=((?:"[^"]*"|\[[^\]]*\]|[^\s'":;,])+)'?/g, OPTION = /\s*\((?:or )?--[a-z][^()]*\)/g, BARE_OPTION = /--([a-z][a-z-]*)/g;
const STATED = /\b([a-z]\w*(?:\.\w+(?:\[\d+\])?)*) = ("[^"]*"|\[[^\]]*\]|true\b|false\b|-?\d[\d.]*|[a-z]\w*)/g;
const TABLE = /\[\[?([a-z]\w*(?:\.[a-z]\w*)*)\]\]?/g, PATH = /\b[a-z]\w*(?:\[\d+\])?(?:\.[a-z]\w*(?:\[\d+\])?)+\b/g, KEY = /(?<![\w./\\])[a-z]+(?:_[A-Za-z0-9]+)+\b(?!\.\w)/g;
function tableWords(path) {
  const kind = kinds.of(path.split(".").at(-1));
  return kind ? t("{kind}: limits", { kind: t(kind.noun) }) : t(TABLES[path] || inWords(path));
}
export function said(message) {
  return String(message ?? "").replace(/^job\.toml: /, "").replace(/\bjob\.toml\b/g, t("the job")).replace(OPTION, "").replace(/(--set (?:'[^']*'|\S+)) (?=--set )/g, "$1; ")
    .replace(SET, (whole, path, value) => `${labelOf(path)}: ${valueOf(value.replace(/^\[("[^"]*")\]$/, "$1"))}`)
    .replace(STATED, (whole, path, value) => (isKnown(path) || path.includes("_") ? `${labelOf(path)}: ${valueOf(value)}` : whole))
    .replace(TABLE, (whole, path) => (isTable(path.split(".")[0]) ? tableWords(path) : whole))
    .replace(PATH, (path) => (isTable(path.split(/[.[]/)[0]) ? labelOf(path) : path))
    .replace(KEY, (key) => labelOf(key)).replace(BARE_OPTION, (whole, name) => `“${name.replaceAll("-", " ")}”`);
}
sayIn(said);
