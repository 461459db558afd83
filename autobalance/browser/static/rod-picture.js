// Where each of the usual parts is: a rod with its piston on a crankpin; the part that is being weighed stands out.
import { html } from "/static/preact.min.js";
import { t } from "/static/words.js";

const PARTS = {
  connecting_rod_big_end: "M44 132l-4 34a22 22 0 1 0 40 0l-4 -34z",
  big_end_bearing: "M60 160a16 16 0 1 0 .1 0z",
  connecting_rod_small_end: "M50 66l-6 64h32l-6 -64z",
  piston: "M26 18h68v58h-14v-18h-40v18h-14z",
  wrist_pin: "M60 46a8 8 0 1 0 .1 0z",
  rings_clips_oil: "M24 24h72v3h-72zM24 31h72v3h-72z",
  oil: "M60 165a11 11 0 1 0 .1 0z",
};
export function RodPicture({ part }) {
  const drawn = ["connecting_rod_small_end", "connecting_rod_big_end", "piston", "rings_clips_oil", "wrist_pin", "big_end_bearing", "oil"];
  return html`<svg class="rod" viewBox="14 8 92 200" role="img" aria-label=${t("Where the parts are: piston above, rod, crankpin below")}>${drawn.map((name) => html`<path key=${name} d=${PARTS[name]} class=${name === part ? "chosen" : ""}/>`)}</svg>`;
}
