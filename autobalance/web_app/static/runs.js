// Runs: several at once, each followed to its end; a page that comes back finds them.
import { $, el } from "/static/tools.js";
import { askJson, guarded, post, say } from "/static/server.js";
import { emit } from "/static/job.js";

const ENDED = ["done", "failed", "cancelled"];
const following = new Map(); // id → { resolve, reject }
let polling = false;
let newest = null;
const words = {}; // id → what it is of, for people

export async function start(verb, body, name = "", meanwhile = null) {
  const { id } = await post("/api/runs", { verb, ...body });
  words[id] = name;
  return follow(id, verb, meanwhile);
}

// Resolve with what is told of a run once it is done; null when it was cancelled. `meanwhile` is told how far it is.
export function follow(id, verb, meanwhile = null) {
  if (verb !== "inspect") newest = id;
  const end = new Promise((resolve, reject) => following.set(id, { resolve, reject, meanwhile }));
  poll();
  return end;
}

async function poll() {
  if (polling) return;
  polling = true;
  try {
    while (following.size) {
      const { runs } = await askJson("/api/runs");
      list(runs);
      for (const told of runs) {
        const end = following.get(told.id);
        if (!end) continue;
        if (!ENDED.includes(told.state)) { end.meanwhile?.(told); continue; }
        following.delete(told.id);
        if (told.state === "failed") end.reject(Object.assign(new Error(told.error), { run: told.id }));
        else end.resolve(told.state === "done" ? told : null);
      }
      if (following.size) await new Promise((resolve) => setTimeout(resolve, 120));
    }
  } catch (error) {
    for (const end of following.values()) end.reject(error);
    following.clear();
  } finally {
    polling = false;
    list((await askJson("/api/runs").catch(() => ({ runs: [] }))).runs);
  }
}

export function list(runs) {
  const going = runs.filter((each) => !ENDED.includes(each.state));
  const shown = going.find((each) => each.id === newest) || going[going.length - 1];
  $("cancel").disabled = !shown;
  $("cancel").dataset.run = shown ? shown.id : "";
  const last = shown || runs.find((each) => each.id === newest) || runs.findLast((each) => each.verb !== "inspect") || runs.at(-1);
  if (last) progress(last); // a page that comes after the end of a run shows that end
  const items = runs.filter((each) => each.verb !== "inspect" || !ENDED.includes(each.state)).slice(-8).reverse();
  $("run-list").replaceChildren(...items.map(item));
}

function progress(told) {
  const share = Math.round(100 * told.share);
  $("progress").setAttribute("aria-valuenow", String(share));
  $("progress").setAttribute("aria-valuetext", `${told.verb}: ${told.words}`);
  $("progress").firstElementChild.style.setProperty("width", `${share}%`);
  $("progress").lastElementChild.textContent = `${told.verb}: ${told.words}`;
}

function item(told) {
  const text = el("span", { textContent: `${told.verb}${words[told.id] ? ` ${words[told.id]}` : ""}: ${told.state === "running" ? `${told.words}, ${Math.round(100 * told.share)} %` : told.state}${told.error ? ` – ${told.error}` : ""}` });
  const made = el("li", { data: { run: told.id, state: told.state } }, text);
  if (!ENDED.includes(told.state)) {
    const end = el("button", { type: "button", textContent: "Cancel", "aria-label": `Cancel ${told.verb} ${told.id}` });
    end.addEventListener("click", guarded(() => cancel(told.id)));
    made.append(end);
  } else if (told.state === "done" && ["balance", "recut"].includes(told.verb)) {
    const show = el("button", { type: "button", textContent: "Show", "aria-label": `Show ${told.verb} ${told.id}` });
    show.addEventListener("click", () => emit("show", told));
    made.append(show);
  }
  return made;
}

export const cancel = (id) => post(`/api/runs/${id}/cancel`, {});

// Follow a run for a person; what goes wrong is said.
export async function watched(work) {
  try { return await work(); } catch (error) { say(error.message); return null; }
}
