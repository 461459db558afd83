// Alternatives: every kind of correction and the useful mixes on this crank, as cards with pictures.
import { $, el, measured } from "/static/tools.js";
import { askJson, guarded } from "/static/server.js";
import { applied, job, state } from "/static/job.js";
import { start, watched } from "/static/runs.js";

const VERDICTS = { within_tolerance: "within tolerance", already_within_tolerance: "already within tolerance", above_tolerance: "above tolerance" };

export function setUp() {
  $("compare").addEventListener("click", guarded(async () => {
    if (!state.file) throw new Error("open a crank first");
    const told = await watched(() => start("compare", { job: job() }));
    if (told) await board(told);
  }));
}

export async function board(told) {
  const report = await askJson(`/api/runs/${told.id}/report`);
  const cards = report.rows.map((row, place) => card(row, place, told, report.unbeaten.includes(row.method.join("+"))));
  $("board").replaceChildren(...cards);
}

function card(row, place, told, best) {
  const name = row.method.join("+"), file = `${name}.png`;
  const made = el("article", { className: best ? "card best" : "card", "aria-label": name }, el("h3", { textContent: name }));
  if (told.files.includes(file)) made.append(el("img", { src: `/api/runs/${told.id}/files/${encodeURIComponent(file)}`, alt: `The crank corrected by ${name}`, loading: "lazy" }));
  made.append(el("p", { textContent: row.outcome ? VERDICTS[row.outcome] : "no place on this crank" }));
  if (best) made.append(el("p", { className: "quiet", textContent: "nothing beats it" }));
  else if (row.beaten_by?.length) made.append(el("p", { className: "quiet", textContent: `beaten by ${row.beaten_by.join(", ")}` }));
  if (row.reason) made.append(el("p", { className: "quiet", textContent: row.reason }));
  if (row.outcome) {
    const facts = [["Residual", "residual_g_mm", "g·mm"], ["Metal moved", "metal_moved_g", "g"], ["Inertia", "inertia_change_kg_mm2", "kg·mm²"], ["Cuts", "cuts", ""], ["Wall left", "wall_left_mm", "mm"]];
    made.append(el("dl", {}, ...facts.flatMap(([words, key, unit]) => [el("dt", { textContent: words }), el("dd", {}, measured(`rows.${place}.${key}`, row[key], key === "cuts" ? 0 : 2), row[key] === null ? "" : ` ${unit}`)])));
    const take = el("button", { type: "button", textContent: "Take this one", "aria-label": `Take ${name}` });
    take.addEventListener("click", () => applied({ "correction.method": row.method }));
    made.append(take);
  }
  return made;
}
