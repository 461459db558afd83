// Keys for steps, views and the main button, and the list of them; single letters and digits do nothing while a field has the focus.
import { html, useEffect, useRef } from "/static/preact.min.js";
import { $ } from "/static/tools.js";
import { emit, redoJob, state, undoJob } from "/static/job.js";
import { big } from "/static/machine.js";
import { mount, signal } from "/static/store.js";
import { hasWebs } from "/static/webs.js";
import { VIEWS, webs } from "/static/views.js";
import { t } from "/static/words.js";

const STEPS = { 1: "open", 2: "parts", 3: "correct", 4: "see", 5: "machine", a: "analyse", h: "history" };
const isTyping = ({ tagName, type }) => tagName === "TEXTAREA" || tagName === "SELECT" || (tagName === "INPUT" && !["range", "checkbox", "radio", "file"].includes(type));
const isOpen = signal(false);
export const ask = () => { isOpen.value = true; };

// The list that people see: each key and what it does.
export const KEYS = [
  ["1 – 5", "Crank, Engine, Plan, Result, Machine"], ["A", "Analyses"], ["H", "History"], ["B", "Big digits"], ["Ctrl-Z", "Undo"], ["Ctrl-Shift-Z", "Redo"], ["Ctrl-Enter", "The main button"],
  ["F", "Fit the model"], ["E", "Front"], ["R", "Rear"], ["S", "Side"], ["W", "Webs"], ["M", "Move the chosen cut"], ["P", "Shop sheet"], ["?", "This list"],
  ["← → ↑ ↓", "Turn the model; move the cut that has the focus"], ["+ −", "Zoom"], ["Tab", "Through the cuts in the model"], ["Enter", "Down a column; pasted rows fill down"],
];
export const HELP = {
  open: "Open a file, take an example or draw a crank. Answer the questions and check what was recognised. To change it, click a cylinder in the model.",
  parts: "Enter the mass of each part, the factor, the speed and the grade. The line at the foot shows their effect as you type.",
  correct: "Choose a kind of cut and its limits. Cut and measure plans the cuts, makes them in the solid and measures the written file.",
  see: "The verdict, the cuts in the order of set-up, and the documents. Drag a number in the model to change its cut.",
  machine: "Enter the unbalance that the balancing machine reads in each plane. The next cuts follow from it.",
  analyse: "Questions about this crank. Open one to enter what it lacks, then compute and draw it.",
  history: "All cranks with their results. Tick two results to compare them.",
};
const SECTIONS = { open: "1-crank", parts: "2-engine", correct: "3-plan", see: "4-result", machine: "5-machine", analyse: "analyses", history: "history" };

export function setUp(view) {
  mount(Help, $("help-root"));
  const work = {
    ...Object.fromEntries(Object.entries(STEPS).map(([key, tab]) => [key, () => emit("tab", tab)])),
    ...Object.fromEntries(VIEWS.map((each) => [each[2], () => view.toView(each)])),
    w: () => hasWebs() && webs(),
    b: () => { if (state.result) { emit("tab", "machine"); big.value = true; } },
    m: move,
    p: () => $("downloads")?.querySelector("[data-file='sheet.pdf']")?.click(),
    "?": ask,
  };
  document.addEventListener("keydown", (event) => {
    if (document.querySelector("dialog[open]")) return;
    if ((event.ctrlKey || event.metaKey) && event.key === "Enter") {
      document.activeElement?.blur(); // what is being typed counts
      document.querySelector(".line button.main, .first button.main")?.click();
      event.preventDefault();
      return;
    }
    if (isTyping(event.target)) return;
    const back = (event.ctrlKey || event.metaKey) && !event.defaultPrevented && { z: event.shiftKey ? redoJob : undoJob, Z: redoJob, y: redoJob }[event.key];
    if (back && back()) event.preventDefault();
    if (event.ctrlKey || event.metaKey || event.altKey || !work[event.key.toLowerCase()]) return;
    work[event.key.toLowerCase()]();
    event.preventDefault();
  });
}

// The handle of the cut that was chosen in the table, else of the first: arrows move it.
function move() {
  if (!state.result) return;
  emit("tab", "see");
  const number = document.querySelector("#cuts tr[aria-selected=true] [data-cut]")?.dataset.cut;
  requestAnimationFrame(() => document.querySelector(number ? `.handle[data-cut="${number}"]` : ".handle")?.focus({ preventScroll: true }));
}

function Help() {
  const box = useRef(null), tab = document.body.dataset.tab, docs = document.querySelector("meta[name=autobalance-docs]").content;
  useEffect(() => { if (isOpen.value && !box.current.open) box.current.showModal(); if (!isOpen.value && box.current.open) box.current.close(); });
  const close = () => { isOpen.value = false; };
  return html`<dialog ref=${box} id="help" data-testid="help-dialog" aria-labelledby="help-head" onClose=${close}><h2 id="help-head">${t("Help")}</h2><p>${t(HELP[tab])}</p>
    ${docs ? html`<p><a id="help-docs" data-testid="help-docs" target="_blank" rel="noreferrer" href=${`${docs}#${SECTIONS[tab]}`}>${t("This step in the documentation")}</a></p>` : ""}
    <h3>${t("Keys")}</h3><p class="quiet">${t("Letters and digits do nothing while a field has the focus.")}</p><table class="keys"><tbody>${KEYS.map(([key, words]) => html`<tr key=${key}><th scope="row"><kbd>${key}</kbd></th><td>${t(words)}</td></tr>`)}</tbody></table>
    <p class="buttons"><button type="button" data-testid="help-close" onClick=${close}>${t("Close")}</button></p></dialog>`;
}
