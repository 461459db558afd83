// Settings of the page: its units and its language.
import { html } from "/static/preact.min.js";
import { ask } from "/static/keys.js";
import { mount } from "/static/store.js";
import { $ } from "/static/tools.js";
import { at, emit, on } from "/static/job.js";
import { SYSTEMS, measureIn, units, wasChosen } from "/static/units.js";
import { LANGUAGES, language, speak, t } from "/static/words.js";

export function setUp() {
  mount(Settings, $("settings"));
  on("taken", () => { if (!wasChosen()) measureIn(at("shop.units") === "inch" ? "oz-in" : "metric", false); });
}

function Settings() {
  const measure = ({ target }) => { measureIn(target.value); emit("units"); };
  return html`<select id="units" data-testid="units" aria-label=${t("Units")} value=${units.value} onInput=${measure}>${Object.entries(SYSTEMS).map(([name, says]) => html`<option value=${name}>${says}</option>`)}</select>
    <select id="language" data-testid="language" aria-label=${t("Language")} value=${language} onInput=${({ target }) => speak(target.value)}>${Object.entries(LANGUAGES).map(([name, says]) => html`<option value=${name}>${says}</option>`)}</select>
    <button type="button" class="bare help-button" data-testid="help-open" aria-label=${t("Help and keys")} title=${t("Help and keys")} aria-keyshortcuts="?" onClick=${ask}>?</button>`;
}
