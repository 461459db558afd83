// Asking the server, with the page's token; what it refuses is said in one line.
import { $ } from "/static/tools.js";

// The page that the printed address opens has the token; it stays in this tab, for reloads.
const told = document.querySelector("meta[name=autobalance-token]").content;
if (told) sessionStorage.setItem("autobalance-token", told);
const token = told || sessionStorage.getItem("autobalance-token") || "";

export async function ask(path, options = {}) {
  let answer;
  try {
    answer = await fetch(path, { ...options, headers: { "X-Autobalance-Token": token, ...(options.headers || {}) } });
  } catch {
    throw new Error("the server does not answer; was it ended? Start `autobalance app` again");
  }
  if (answer.ok) return answer;
  const told = await answer.json().catch(() => ({ error: answer.statusText }));
  throw Object.assign(new Error(told.error), { status: answer.status, told });
}
export const askText = async (path) => (await ask(path)).text();
// Answers that came with the first one: each is taken once instead of asking for it.
const early = new Map();
export const came = (answers) => { for (const [path, answer] of Object.entries(answers)) early.set(path, answer); };
function taken(path) {
  const answer = early.get(path);
  early.delete(path);
  return answer;
}
export const askJson = async (path, options) => (options ? undefined : taken(path)) ?? (await ask(path, options)).json();
// What a run left for the page; null where it came from elsewhere without that.
const left = (read) => async (path) => { const early = taken(path); if (early) return early; const answer = await ask(path); return answer.status === 204 ? null : answer[read](); };
export const askBuffer = left("arrayBuffer");
export const askLeft = left("json");
// Fingerprint of the job that this page knows: a job that another tab has changed since is not written over.
let version = "";
export const knows = (found) => { version = found.job_version || version; return found; };
export const post = async (path, body) => knows(await askJson(path, { method: "POST", body: JSON.stringify(body) }));
export const remove = (path) => askJson(path, { method: "DELETE" });
let saved = Promise.resolve(); // one after the other: each goes on from the version that the one before made
export const put = (path, body) => {
  saved = saved.catch(() => {}).then(async () => knows(await askJson(path, { method: "PUT", body: JSON.stringify(body), headers: version ? { "If-Match": version } : {} })));
  return saved;
};
const wording = { of: (text) => text || "" };
export const sayIn = (words) => { wording.of = words; }; // as people read it: with the labels of fields
export const say = (text) => { $("error").textContent = wording.of(text); };

// Work that a person began: what goes wrong is said, what was said before goes.
export function guarded(work) {
  const done = behind(work);
  return (...given) => { say(""); return done(...given); };
}
// Work behind the page's back: what went wrong with a person's own stays to be read.
export function behind(work) {
  return async (...given) => {
    try { return await work(...given); } catch (error) { say(error.message); return undefined; }
  };
}
