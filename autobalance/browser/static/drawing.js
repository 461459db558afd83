// A crank that was drawn here: its dimensions, the bob-weights that its counterweights suit, and drawing it again with others.
import { html } from "/static/preact.min.js";
import { withUnit } from "/static/tools.js";
import { post } from "/static/server.js";
import { ofFile, state } from "/static/job.js";
import { Field } from "/static/fields.js";
import { listed } from "/static/limits.js";
import { preview } from "/static/parts.js";
import { redraw, signal } from "/static/store.js";
import { inWords, t } from "/static/words.js";

const RADIUS = "counterweight.radius_mm", MOST = "most_bob_weight_g";
const FIELDS = [["stroke_mm", "Stroke", "mm", "Stroke: twice the distance of the crankpins from the axis"], ["main_journal.diameter_mm", "Main journal ⌀", "mm", "Diameter of the main journals"], ["crankpin.diameter_mm", "Crankpin ⌀", "mm", "Diameter of the crankpins"], ["web.thickness_mm", "Web thickness", "mm", "Thickness of each web along the axis"], ["counterweight.fan_angle_deg", "Fan angle", "°", "Angle of a counterweight's sector about the axis"], ["oil_hole_mm", "Oil hole ⌀", "mm", "Diameter of the straight oil holes; 0: none"],
  [MOST, "Largest bob-weight", "g", "Heaviest bob-weight that the counterweights balance. For lighter ones metal is drilled off: on the V8 this reaches down to two thirds of it. Without a number: usual parts of such an engine."], [RADIUS, "Counterweight radius", "mm", "Outside radius of the counterweights. Without a number: drawn for the largest bob-weight."]];
const typing = signal({ file: "", values: {}, why: "", busy: false }); // dimensions that are typed, of the crank of a file
let opens = () => {};
export const setUp = (open) => { opens = open; };

const drawn = () => state.cranks[state.file]?.drawn || null;
const kept = () => Object.fromEntries((drawn()?.typed || []).map((key) => [key, drawn().dimensions[key]]).concat(drawn()?.is_most_typed ? [[MOST, drawn().most_bob_weight_g]] : []));
const values = () => (typing.value.file === state.file ? typing.value.values : kept());
const grams = (value) => withUnit(Math.floor(value), 0, "g");

// Draw the crank with these dimensions as another file: weights and limits of the job stay.
async function draw(dimensions) {
  const file = state.file, { [MOST]: most = null, ...sizes } = dimensions;
  typing.value = { file, values: dimensions, why: "", busy: true };
  try {
    const answer = await post("/api/cranks/draw", { file, dimensions: sizes, most_bob_weight_g: most });
    if (file !== state.file) return;
    state.cranks = answer.cranks;
    typing.value = { file: "", values: {}, why: "", busy: false };
    if (answer.file === file) { redraw(); return; }
    listed.cuts = null; // those of the other solid
    ofFile(answer.file, { "crankshaft.unit": "mm", "crankshaft.main_journals": undefined, "crankshaft.crankpins": undefined });
    await opens();
  } catch (error) {
    typing.value = { file, values: dimensions, why: worded(error.message), busy: false };
  }
}
// The labels of the fields in place of their keys, and other keys as words.
const worded = (message) => inWords(FIELDS.reduce((text, [key, words]) => text.replaceAll(key, t(words)), message));

// --- in Crank -------------------------------------------------------------------------------------------------

export function Drawn() {
  const known = drawn();
  if (!known) return "";
  const { dimensions, most_bob_weight_g: most } = known, radius = withUnit(dimensions[RADIUS], 1, "mm");
  const says = most === null ? t("Counterweights drawn with a radius of {radius}. The throws cancel each other out, so no bob-weight counts.", { radius }) : most > 0 ? t("Counterweights drawn with a radius of {radius} for bob-weights up to {mass}.", { radius, mass: grams(most) }) : t("Counterweights drawn with a radius of {radius}: too light for any bob-weight.", { radius });
  return html`<p class="quiet" data-testid="drawn">${says}</p><details class="fold" id="dimensions" data-testid="dimensions"><summary>${t("Dimensions")} <small>${t("drawn")}</small></summary><${Dimensions} known=${known}/></details>`;
}
function Dimensions({ known }) {
  const now = values(), { why, busy } = typing.value.file === state.file ? typing.value : {}, wrong = Object.entries(now).find(([, value]) => typeof value !== "number");
  const set = (key) => (value) => { const next = { ...values(), [key]: value }; if (value === undefined) delete next[key]; typing.value = { file: state.file, values: next, why: "", busy: false }; };
  const field = ([key, words, unit, says]) => html`<${Field} key=${key} id=${`drawn-${key.replaceAll(".", "-")}`} testid=${`drawn-${key}`} field=${{ key, words, unit, says, kind: "number", default: key === MOST ? (known[MOST] > 0 ? String(Math.floor(known[MOST])) : "") : String(known.dimensions[key]) }} now=${now[key]} set=${set(key)}/>`;
  const isBoth = RADIUS in now && MOST in now, says = isBoth ? t("A number for the counterweight radius or the largest bob-weight, not both") : wrong ? t("{field}: enter a number.", { field: t(FIELDS.find(([key]) => key === wrong[0])[1]) }) : why;
  const fields = known[MOST] === null ? FIELDS.filter(([key]) => key !== MOST) : FIELDS;
  return html`<div class="fields">${fields.map(field)}</div><p class="note" role="alert">${says}</p>
    <p class="buttons"><button type="button" data-testid="draw-again" disabled=${Boolean(busy || wrong || isBoth)} onClick=${() => draw(now)}>${t(busy ? "Drawing …" : "Draw it again")}</button></p>`;
}

// --- in Engine ------------------------------------------------------------------------------------------------

const LEAST_SHARE = 2 / 3, SPARE = 1.2; // of the largest bob-weight: what drilling reaches down to; what is left to drill off
// Counterweights that do not suit the bob-weight of the job, and the one step that helps; null where they suit.
export function unsuited() {
  const known = drawn(), bobs = preview.value.found?.bob_weights || [], most = known?.[MOST];
  if (!known || most === null || !bobs.length) return null;
  const mass = Math.max(...bobs.map((each) => each.mass_g));
  if (mass <= most && mass >= LEAST_SHARE * most) return null;
  const { busy, why } = typing.value.file === state.file ? typing.value : {}, given = { mass: grams(mass), most: grams(most) };
  const next = () => { const sizes = kept(); delete sizes[RADIUS]; return draw({ ...sizes, [MOST]: Math.ceil(SPARE * mass) }); };
  const says = mass > most ? t("The counterweights were drawn for bob-weights up to {most}; {mass} is more. They are too light.", given) : t("The counterweights were drawn for bob-weights up to {most}; {mass} is much less. Drilling may not reach it.", given);
  return { says: why || says, more: { id: "draw-for", off: Boolean(busy), text: busy ? t("Drawing …") : t("Draw them for {mass}", given), work: next } };
}
