// Where a person is on the page: a page that is loaded again comes back there; one that is opened anew begins.
const KEPT = "autobalance-place";

const found = () => JSON.parse(sessionStorage.getItem(KEPT) || "{}");
const again = performance.getEntriesByType("navigation")[0]?.type === "reload";
const before = again ? found() : {};

export const left = () => before;
export const keep = (change) => sessionStorage.setItem(KEPT, JSON.stringify({ ...found(), ...change }));
addEventListener("pagehide", () => keep({ top: document.getElementById("panels").scrollTop, page: scrollY }));
