// Correct: kinds, limits, faces and angles picked in the model; cut and measure; alternatives as a board.
import { $, el, measured, predicted } from "/static/tools.js";
import { guarded, say } from "/static/server.js";
import { changed, emit, job, on, state } from "/static/job.js";
import { faces, isPoint, sectors, zoneRows, zones } from "/static/limits.js";
import { unitOf } from "/static/units.js";
import { t } from "/static/words.js";
import { cancel, start, watched } from "/static/runs.js";

let view = null;
let picking = null; // angles of a zone that is being picked in the model

export function setUp(model) {
  view = model;
  $("balance").addEventListener("click", () => balance());
  $("cancel").addEventListener("click", guarded(async () => { if ($("cancel").dataset.run) await cancel($("cancel").dataset.run); }));
  $("pick-zone").addEventListener("click", () => { picking = []; told("click in the model where the zone begins"); });
  on("opened", faceRows);
  for (const name of ["taken", "units"]) on(name, faceRows);
  on("job", marks);
  on("forgotten", () => { faces.clear(); $("faces").replaceChildren(); });
}
const told = (text) => { $("pick-says").textContent = text; };

// --- faces and angles -------------------------------------------------------------------------------------

function faceRows() {
  const found = state.inspected?.report.faces || [];
  const points = [...faces].filter(isPoint).map((point) => faceRow(point, ["the face at this point of the file [mm]"]));
  $("faces").replaceChildren(...points, ...found.map((face, k) => {
    const worth = Math.hypot(...face.unbalance_per_mm_g_mm);
    return faceRow(face.id, [`web ${face.web ?? "–"}, `, measured(`faces.${k}.area_mm2`, face.area_mm2, 0), ` ${unitOf("mm²")}, `, predicted(worth, 0), " g·mm per mm"]);
  }));
  if (!found.length) $("faces").append("Open the crank first.");
}

function faceRow(id, says) {
  const input = el("input", { type: "checkbox", checked: faces.has(id) });
  input.addEventListener("change", () => use(id, input.checked));
  return el("label", { className: "check", data: { face: id } }, input, ` ${id} `, el("small", {}, ...says));
}

function use(id, chosen) {
  if (chosen) faces.add(id); else faces.delete(id);
  for (const each of $("faces").querySelectorAll("label")) each.querySelector("input").checked = faces.has(each.dataset.face);
  changed();
}

// What is chosen, in the model's colours.
export function marks() {
  if (!view.parts.length || $("panel-correct").hidden) return;
  view.mark(view.parts.flatMap((part, k) => (part.kind === "face" && faces.has(part.id) ? [k + 1] : [])));
  view.sectors($("zones-box").hidden || !zones.list.length ? [] : sectors());
}

export function pickedInModel(hit) {
  if (!hit) return;
  if (picking) { angle(hit.point); return; }
  const part = view.parts[hit.part - 1];
  if ($("faces-box").hidden || !part || part.kind !== "face") { told(part ? `that is ${part.kind.replace("_", " ")} ${part.number}` : "that is no face that a correction can use"); return; }
  use(part.id, !faces.has(part.id));
  told(`face ${part.id} ${faces.has(part.id) ? "chosen" : "left out"}`);
}

function angle([x, y]) {
  picking.push(Math.round(((Math.atan2(y, x) * 180) / Math.PI + 360) % 360));
  if (picking.length === 1) { told(`from ${picking[0]}°; click where it ends, counter-clockwise`); return; }
  zones.list.push({ from: picking[0], to: picking[1], allowed: $("zone-kind").value === "allowed" });
  told(`${$("zone-kind").value} from ${picking[0]}° to ${picking[1]}°`);
  picking = null;
  zoneRows();
  changed();
}

// --- cut and measure --------------------------------------------------------------------------------------

export const balance = guarded(async () => {
  if (!state.file) throw new Error("open a crank first");
  emit("begun");
  const told = await watched(() => start("balance", { job: job() }, $("method").value));
  if (told) { emit("show", told); emit("tab", "see"); }
});
export { say };
