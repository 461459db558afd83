// Webs of a result, each on its degree wheel, and sections: the drawings of the shop sheet in place of the model.
import { html, useEffect, useRef } from "/static/preact.min.js";
import { $ } from "/static/tools.js";
import { askLeft, behind } from "/static/server.js";
import { on, state } from "/static/job.js";
import { mount, signal } from "/static/store.js";
import { zeroWords } from "/static/zero.js";
import { t } from "/static/words.js";

export const isShown = signal(false);
const drawn = signal({ id: "", webs: [] });

export function setUp() {
  mount(Webs, $("webs"));
  on("result", behind(async ({ id }) => {
    const webs = (await askLeft(`/api/runs/${id}/webs`)) || [];
    if (state.result?.id === id) drawn.value = { id, webs };
  }));
}
// Whether the result that is shown has webs to draw.
export const hasWebs = () => Boolean(state.result) && drawn.value.id === state.result.id && drawn.value.webs.length > 0 && ["see", "machine"].includes(document.body.dataset.tab);

function Webs() {
  const isOpen = isShown.value && hasWebs();
  $("webs").hidden = !isOpen;
  return isOpen ? html`<p>${zeroWords()}</p><${Some} kind="web"/>${of("section").length ? html`<h2>${t("Sections")}</h2><${Some} kind="section"/>` : ""}` : "";
}
const of = (kind) => drawn.value.webs.filter((each) => (each.kind || "web") === kind); // an earlier result has webs alone
const Some = ({ kind }) => html`<div class="wheels" data-kind=${kind}>${of(kind).map((each) => html`<${Web} key=${each.title} ...${each}/>`)}</div>`;
function Web({ title, labels, svg, kind = "web" }) {
  const box = useRef(null);
  useEffect(() => { box.current.innerHTML = svg; }, [svg]); // the server's own drawing
  return html`<figure data-testid=${`${kind}-drawn`} data-labels=${JSON.stringify(labels)}><div ref=${box} role="img" aria-label=${`${title}: ${t("Cuts")} ${labels.join(", ")}`}></div><figcaption>${title}</figcaption></figure>`;
}
