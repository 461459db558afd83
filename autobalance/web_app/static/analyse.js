// Analyses of the job: forces, the cycle, shafts and the like; each with its words, its plots, its files.
import { $, el } from "/static/tools.js";
import { askText, guarded, say } from "/static/server.js";
import { job, state } from "/static/job.js";
import { start, watched } from "/static/runs.js";

export function setUp() {
  $("analysis").replaceChildren(...state.analyses.map(({ verb }) => el("option", { textContent: verb })));
  $("analysis").addEventListener("input", chosen);
  $("analyse").addEventListener("click", guarded(run));
  chosen();
}
function chosen() {
  $("analysis-says").textContent = state.analyses.find(({ verb }) => verb === $("analysis").value)?.says || "";
}
export const known = (verb) => state.analyses.some((each) => each.verb === verb);

async function run() {
  const told = await watched(() => start($("analysis").value, { job: job() }));
  if (told) await show(told);
}

// An analysis that is done, before all others; one of the same kind gives way.
export async function show(told) {
  const url = (name) => `/api/runs/${told.id}/files/${encodeURIComponent(name)}`;
  const pictures = told.files.filter((name) => name.endsWith(".png"));
  const figures = pictures.map((name) => el("figure", {}, el("img", { src: url(name), alt: name.replace(/\.png$/, "").replaceAll("-", " "), loading: "lazy" })));
  const files = told.files.filter((name) => !name.endsWith(".png"));
  const links = files.flatMap((name) => [el("a", { href: url(name), download: name, textContent: name }), " "]);
  const words = told.files.includes("summary.txt") ? [el("pre", { tabIndex: 0, "aria-label": `${told.verb} in words`, textContent: await askText(url("summary.txt")) })] : [];
  document.getElementById(`analysis-${told.verb}`)?.remove();
  $("analyses").prepend(el("section", { id: `analysis-${told.verb}` }, el("h2", { textContent: told.verb }), ...words, el("div", { className: "plots" }, ...figures), el("p", {}, ...links)));
  if (!pictures.length) say("there is nothing to draw");
}
