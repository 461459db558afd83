// The first minute: five steps from the crank to the machine, each on its tab; it goes when one has enough of it.
import { html } from "/static/preact.min.js";
import { $ } from "/static/tools.js";
import { emit, on, state } from "/static/job.js";
import { mount, signal } from "/static/store.js";
import { t } from "/static/words.js";

const KEPT = "autobalance-tour";
const STEPS = [
  ["open", "Drop a crank here, open the bundled one, or draw one: it is there to turn, and the tree names what was recognised."],
  ["parts", "Enter what the scale says. Bob-weights and unbalance follow as you type; the layout says how many rods are on a pin."],
  ["correct", "Choose how metal may go: drill, mill, turn, heavy metal. Press Balance, or compare all kinds."],
  ["see", "The verdict is measured on the written solid. Choose a cut and the view turns to it; drag a number to change it. Sheet and certificate are here."],
  ["machine", "Make the cuts, spin the crank, enter what the machine reads: the next cuts follow. NC programs are here, too."],
];
const step = signal(-1); // -1: no tour

export function setUp() {
  mount(Tour, $("tour"));
  on("tour", () => { step.value = 0; emit("tab", STEPS[0][0]); });
  on("selected", (tab) => { // who goes on without it takes it along
    const found = STEPS.findIndex(([name]) => name === tab);
    if (step.value >= 0 && found >= 0) step.value = found;
  });
  if (!state.file && !localStorage.getItem(KEPT)) step.value = 0;
}

function Tour() {
  if (step.value < 0) return null;
  const last = step.value === STEPS.length - 1;
  const to = (next) => { step.value = next; emit("tab", STEPS[next][0]); };
  const end = () => { localStorage.setItem(KEPT, "seen"); step.value = -1; };
  return html`<aside class="tour" aria-label=${t("Tour")} data-testid="tour" data-step=${String(step.value + 1)}><p><strong>${t("Step {place} of {count}", { place: step.value + 1, count: STEPS.length })}</strong> ${t(STEPS[step.value][1])}</p>
    <p class="buttons">${last ? "" : html`<button type="button" class="main" onClick=${() => to(step.value + 1)}>${t("Next")}</button>`}${step.value ? html`<button type="button" onClick=${() => to(step.value - 1)}>${t("Back")}</button>` : ""}<button type="button" data-testid="end-tour" onClick=${end}>${t("End the tour")}</button></p></aside>`;
}
