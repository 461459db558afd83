// The page's language: its texts, one file each, by the English ones; numbers as its readers write them.
export const LANGUAGES = { en: "English", de: "Deutsch", es: "Español" };
const KEPT = "autobalance-language";
const asked = localStorage.getItem(KEPT) || navigator.language.slice(0, 2);
export const language = asked in LANGUAGES ? asked : "en";
export const locale = language === navigator.language.slice(0, 2) ? navigator.language : language;
const texts = await (await fetch(`/static/text-${language}.json`)).json();

// A text in the reader's language; names in braces stand for values.
export function t(english, values = {}) {
  return (texts[english] || english).replace(/\{(\w+)\}/g, (whole, name) => (name in values ? values[name] : whole));
}

export function speak(next) {
  localStorage.setItem(KEPT, next);
  location.reload();
}

// Names of keys within a sentence, and words to choose, as words.
const KEY = /\b[a-z][\w.]*_[\w.]*\w\b/g, UNIT = /_(g_mm2?|kg_mm2|kg_m3|mm2?|m_s|N_m|deg|rad|rpm|percent|g|K|C|MPa)$/;
export const inWords = (text) => text.replace(KEY, (name) => name.replace(UNIT, "").replace(/[._]/g, " "));

const ATTRIBUTES = ["aria-label", "title", "placeholder"];
// What stands in the page as it is loaded.
export function translated(root) {
  document.documentElement.lang = language;
  if (language === "en") return;
  const walker = document.createTreeWalker(root, NodeFilter.SHOW_TEXT);
  while (walker.nextNode()) {
    const node = walker.currentNode, text = node.data.trim().replace(/\s+/g, " ");
    if (texts[text]) node.data = node.data.replace(node.data.trim(), texts[text]);
  }
  for (const name of ATTRIBUTES) for (const each of root.querySelectorAll(`[${name}]`)) each.setAttribute(name, t(each.getAttribute(name)));
}

const formats = {};
const POINT = new Intl.NumberFormat(locale).formatToParts(1.5).find((part) => part.type === "decimal").value;
export function decimal(value, digits) {
  const format = (formats[digits] ||= new Intl.NumberFormat(locale, { minimumFractionDigits: digits, maximumFractionDigits: digits, useGrouping: false }));
  return format.format(value).replace(/^-(0([.,]0+)?)$/, "$1").replace("-", "\u2212");
}
// A number as it is typed: all its digits, with the reader's decimal sign.
export const plain = (value) => String(value).replace(".", POINT);
