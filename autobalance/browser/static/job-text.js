// The job's text beside the model: to be read, and to be typed.
import { html } from "/static/preact.min.js";
import { $ } from "/static/tools.js";
import { guarded, put } from "/static/server.js";
import { brought, changed, emit, state } from "/static/job.js";
import { mount, redrawNow, signal } from "/static/store.js";
import { t } from "/static/words.js";

const typed = signal(null); // the text as it is being typed; null: it is not

export const setUp = () => mount(JobText, $("job-text-root"));

function edit() {
  typed.value = state.text;
  redrawNow();
  $("job-toml").focus();
}
const leave = () => { typed.value = null; };
const take = guarded(async () => {
  await brought(() => put("/api/job/text", { toml: typed.value }));
  leave();
  changed();
  emit("typed");
});

function JobText() {
  const isTyped = typed.value !== null;
  return html`<pre data-testid="job-text" id="job-text" tabindex="0" hidden=${isTyped}>${state.text}</pre>
    <button type="button" id="edit-job" data-testid="edit-job" hidden=${isTyped} onClick=${edit}>${t("Edit the text")}</button>
    <div id="job-edit" hidden=${!isTyped}><label for="job-toml">${t("The job's text")}</label><textarea id="job-toml" data-testid="job-toml" rows="16" spellcheck=${false} value=${typed.value ?? ""} onInput=${({ target }) => { typed.value = target.value; }}></textarea>
    <p class="buttons"><button type="button" id="take-job" data-testid="take-job" class="main" onClick=${take}>${t("Use this job")}</button> <button type="button" id="leave-job" onClick=${leave}>${t("Discard the changes")}</button></p></div>`;
}
