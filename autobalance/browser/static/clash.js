// Two tabs with one job: what the other saved meanwhile is put together with what was typed here, as a person says.
import { html, useEffect, useRef } from "/static/preact.min.js";
import { askJson, behind, guarded, knows } from "/static/server.js";
import { changed, edits, isComing, isKeptSince, job, sinceSaved, state, taken } from "/static/job.js";
import { mount, signal } from "/static/store.js";
import { changeText } from "/static/verdict.js";
import { t } from "/static/words.js";

const clash = signal(null); // { changes }: the job that another tab saved, key by key
const channel = new BroadcastChannel("autobalance-job");
export const told = () => channel.postMessage(state.text);
export const met = ({ changes = [] }) => { clash.value = { changes }; };

export function setUp(box) {
  mount(Clash, box);
  channel.onmessage = ({ data }) => { if (data !== state.text) news(); };
}

// Another tab may have changed the job; what was typed here since goes first.
export const news = behind(async () => {
  const before = edits(), found = await askJson("/api/project");
  if (!isKeptSince(before) || isComing() || found.job_text === state.text) return;
  state.text = knows(found).job_text;
  taken(found.job);
});

const answered = (isBoth) => guarded(async () => {
  const found = knows(await askJson("/api/project"));
  state.text = found.job_text;
  taken(isBoth ? sinceSaved(found.job) : found.job);
  clash.value = null;
  changed();
});

function Clash() {
  const box = useRef(null), isMet = clash.value !== null;
  useEffect(() => { if (isMet && !box.current.open) box.current.showModal(); if (!isMet && box.current.open) box.current.close(); });
  return html`<dialog ref=${box} id="clash" data-testid="clash" aria-labelledby="clash-head" onCancel=${(event) => event.preventDefault()}><h2 id="clash-head">${t("This job was changed in another tab")}</h2>
    <table><thead><tr><th scope="col">${t("Key")}</th><th scope="col">${t("here → there")}</th></tr></thead><tbody>${(clash.value?.changes || []).slice(0, 8).map((each) => html`<tr><th scope="row">${changeText(each).split(": ")[0]}</th><td>${changeText(each).split(": ").slice(1).join(": ")}</td></tr>`)}</tbody></table>
    <p class="buttons"><button type="button" class="main" data-testid="keep-both" onClick=${answered(true)}>${t("Keep both")}</button> <button type="button" data-testid="take-theirs" onClick=${answered(false)}>${t("Take theirs")}</button></p></dialog>`;
}
