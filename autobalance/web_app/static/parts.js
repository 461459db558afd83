// Parts: the table of weights, and what they do to the crank as one types.
import { $, debounced, el, predicted, shown } from "/static/tools.js";
import { post } from "/static/server.js";
import { GROUPS, changed, job, on, state, sumOf } from "/static/job.js";
import { polar } from "/static/polar.js";

export function setUp() {
  on("taken", rows);
  on("job", preview);
  on("opened", preview);
  on("forgotten", () => { $("preview").hidden = true; });
  for (const id of ["factor", "grade", "speed-rpm", "judge"]) $(id).addEventListener("input", changed);
  rows();
}

function rows() {
  $("weights").replaceChildren(...Object.entries(GROUPS).map(([group, title]) => {
    const add = el("button", { type: "button", textContent: "Add a part", "aria-label": `Add a part: ${title}`, data: { testid: `add-${group}` } });
    add.addEventListener("click", () => {
      state.weights[group].push({ name: "", g: "", pm: "", pieces: "" });
      rows();
      [...document.querySelectorAll(`[data-group=${group}] [data-testid=weight-name]`)].pop()?.focus();
    });
    return el("div", { className: "weights", role: "group", "aria-label": title }, el("h2", {}, `${title} `, el("small", { textContent: "name, pieces, g each, ± g" })), ...state.weights[group].map((row, place) => line(group, row, place)), el("p", { className: "quiet", data: { testid: `sum-${group}` } }), add);
  }));
  sums();
}

// What each group weighs, and how many of its rows were not weighed yet.
function sums() {
  for (const [group, rows] of Object.entries(state.weights)) {
    const total = sumOf(rows), open = rows.filter((row) => row.raw === undefined && String(row.g).trim() === "").length;
    const words = [total === null ? "" : `${shown(total, 2)} g in all`, open ? `${open} not weighed: not in the job` : ""];
    document.querySelector(`[data-testid=sum-${group}]`).textContent = words.filter((each) => each).join("; ");
  }
}

function line(group, row, place) {
  const made = el("div", { data: { testid: "weight-row", group } });
  for (const [key, words] of [["name", "name"], ["pieces", "pieces"], ["g", "mass of each in grams"], ["pm", "plus or minus in grams"]]) {
    const input = el("input", { value: row[key], "aria-label": `${GROUPS[group]}, part ${place + 1}: ${words}`, data: { testid: `weight-${key}` } });
    if (key !== "name") input.inputMode = "decimal";
    if (key !== "name" && row.raw !== undefined) { input.readOnly = true; input.placeholder = key === "g" ? "in the job" : ""; }
    if (key === "pieces" && row.raw === undefined) input.placeholder = "1";
    if (key === "name" && row.hint) input.title = row.hint;
    input.addEventListener("input", () => { row[key] = input.value; sums(); changed(); });
    made.append(input);
  }
  const remove = el("button", { type: "button", textContent: "×", "aria-label": `Remove ${row.name || "this part"}` });
  remove.addEventListener("click", () => { state.weights[group].splice(place, 1); rows(); changed(); });
  made.append(remove);
  made.addEventListener("paste", (event) => pasted(event, group, place));
  return made;
}

// Rows of a spreadsheet: name, grams, plus or minus; a row without a number is a heading.
function pasted(event, group, place) {
  const cells = event.clipboardData.getData("text").trim().split(/\r?\n/).map((text) => text.split("\t").map((cell) => cell.trim()));
  if (cells.length < 2 && cells[0].length < 2) return;
  event.preventDefault();
  const number = (text) => (text || "").replace(/\s*g$/, "").replace(",", ".");
  const found = cells.map(([name, g, pm]) => ({ name: name.replace(/\s+/g, "_"), g: number(g), pm: number(pm).replace("±", ""), pieces: "" })).filter((row) => row.name && row.g !== "" && Number.isFinite(Number(row.g)));
  state.weights[group].splice(place, 1, ...found);
  rows();
  changed();
}

// --- as one types -----------------------------------------------------------------------------------------

let asked = 0;
const preview = debounced(async () => {
  if (!state.inspected) return;
  const mine = ++asked;
  let found = null, why = "";
  try { found = await post(`/api/runs/${state.inspected.id}/preview`, job()); } catch (error) { why = error.message; }
  if (mine !== asked) return;
  if (found?.why) { why = found.why.replace(/^job\.toml: /, ""); found = null; }
  $("preview-why").textContent = why;
  $("preview").hidden = !found;
  if (!found) return;
  const factor = found.balance_factor.initial;
  const facts = [
    ...found.bob_weights.map((each) => [`Bob-weight, throw ${each.throw}`, each.mass_g, "g"]),
    ["Balance factor before", factor, ""],
    ["Unbalance before", found.initial.magnitude_g_mm, "g·mm"],
    ["Permitted", found.tolerance.permissible_g_mm, "g·mm"],
  ];
  $("preview-facts").replaceChildren(...facts.flatMap(([name, value, unit]) => [el("dt", { textContent: name }), el("dd", {}, predicted(value, unit ? 2 : 4), ` ${unit}`)]));
  const places = found.initial.planes.map((plane, k) => [`Plane ${plane.name}`, plane, found.tolerance.planes[k].permissible_g_mm]);
  const plots = [["Resultant", found.initial, found.tolerance.permissible_g_mm], ...places];
  $("preview-polar").replaceChildren(...plots.map(([name, unbalance, permitted]) => polar(name, [{ ...unbalance, name: "before" }], permitted)));
}, 200);
