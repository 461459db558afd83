// The page: what the user knows goes into a job, the server's functions do the work, their numbers are shown.
import { $ } from "/static/tools.js";
import { askJson, behind, came, guarded, knows, say } from "/static/server.js";
import { CRANKS, brought, emit, on, state } from "/static/job.js";
import { ending } from "/static/tools.js";
import * as analyse from "/static/analyse.js";
import * as bigDigits from "/static/big-digits.js";
import * as board from "/static/board.js";
import * as clash from "/static/clash.js";
import * as correct from "/static/correct.js";
import * as drag from "/static/drag.js";
import * as dragPanels from "/static/drag-panels.js";
import * as frame from "/static/frame.js";
import * as history from "/static/history.js";
import * as helpLine from "/static/help-line.js";
import * as jobText from "/static/job-text.js";
import * as keys from "/static/keys.js";
import * as limits from "/static/limits.js";
import * as machine from "/static/machine.js";
import * as modelTags from "/static/model-tags.js";
import * as nc from "/static/nc.js";
import * as open from "/static/open.js";
import * as parts from "/static/parts.js";
import * as place from "/static/place.js";
import * as printing from "/static/printing.js";
import * as runs from "/static/runs.js";
import * as stageTools from "/static/stage-tools.js";
import * as start from "/static/start.js";
import * as settings from "/static/settings.js";
import { mount, redraw } from "/static/store.js";
import * as see from "/static/see.js";
import { Toast } from "/static/toast.js";
import { t, translated } from "/static/words.js";
import * as webs from "/static/webs.js";
import * as views from "/static/views.js";
import { View } from "/static/view.js";

const view = new View($("model"), $("canvas"), $("model-note"));
$("model").view = view; // for tests, and for scripts that drive the page

// --- tabs -------------------------------------------------------------------------------------------------

const tabs = [...$("tabs").children];
let current = "open";
function select(tab) {
  for (const each of tabs) {
    const chosen = each === tab;
    each.setAttribute("aria-selected", String(chosen));
    each.tabIndex = chosen ? 0 : -1;
    $(each.getAttribute("aria-controls")).hidden = !chosen;
  }
  current = tab.id.replace("tab-", "");
  place.keep({ tab: current });
  document.body.dataset.tab = current;
  $("panels").scrollTop = 0;
  emit("selected", current);
  const result = ["see", "machine"].includes(current) && view.sets.result;
  view.use(result ? "result" : "crank");
  view.point(null);
  if (current === "correct") correct.marks(); else view.mark([]);
  if (view.zones) view.zones.visible = current === "correct";
  view.draw();
}
tabs.forEach((tab, place) => {
  tab.addEventListener("click", () => { say(""); select(tab); }); // an error goes with what it was about
  tab.addEventListener("keydown", (event) => {
    const to = { ArrowRight: place + 1, ArrowLeft: place - 1, Home: 0, End: tabs.length - 1 }[event.key];
    if (to === undefined) return;
    const next = tabs[(to + tabs.length) % tabs.length];
    select(next);
    next.focus();
    event.preventDefault();
  });
});
on("result", ({ id }) => place.keep({ run: id }));
on("clash", clash.met);
on("saved", clash.told);
on("tab", (name) => select($(`tab-${name}`)));
view.onpick = (hit) => { if (current === "open") open.pickedInModel(hit); else if (current === "correct") correct.pickedInModel(hit); };

// --- start ------------------------------------------------------------------------------------------------

async function begin() {
  const before = place.left(), first = await askJson(`/api/start${before.run ? `?run=${before.run}` : ""}`), declared = first.forms;
  came(first.answers);
  Object.assign(state, { declared, usual: declared.parts, presets: declared.presets, analyses: declared.analyses });
  translated(document.body);
  limits.setUp(declared.kinds);
  view.words = t;
  for (const each of [open, correct, see, drag, views, keys, stageTools, modelTags, printing]) each.setUp(view);
  for (const each of [dragPanels, parts, jobText, analyse, board, machine, bigDigits, nc, settings, helpLine, webs, history, start, frame]) each.setUp();
  clash.setUp($("clash-root"));
  mount(Toast, $("toast-root"));
  proposed(await brought(async () => first.project));
  const told = first.runs;
  runs.list(told);
  const own = told.filter((each) => see.isOfThis(each) && each.state === "done"), made = own.filter((each) => ["balance", "recut"].includes(each.verb));
  const shown = made.find((each) => each.id === before.run) || made.pop(), last = (verb) => own.filter((each) => each.verb === verb).pop(), looked = last("inspect");
  if (looked) await opened(looked);
  if (shown) await see.show(shown);
  analyse.later(state.analyses.flatMap(({ verb }) => last(verb) || []));
  board.later(last("compare"));
  if (before.tab === "correct") await board.looked("correct");
  if (before.tab === "analyse") await analyse.looked("analyse");
  select($(`tab-${before.tab}`) || tabs[0]);
  $("panels").scrollTop = before.top || 0;
  scrollTo(0, before.page || 0);
  for (const going of told.filter((each) => ["waiting", "running"].includes(each.state))) again(going);
}

// A project that says no crank has the first that lies in it.
function proposed(found) {
  state.isKnown = true;
  state.text = knows(found).job_text;
  state.cranks = found.cranks;
  state.file ||= found.files.find((name) => CRANKS.includes(ending(name))) || null;
  redraw();
}

// Show the crank of an inspection, if it is still that of the job.
const opened = async (told) => { if (told.crank === state.file) await open.show(told.id); };

// A run that went on while the page was away.
const again = guarded(async (going) => {
  if (["balance", "recut"].includes(going.verb)) emit("begun");
  const told = await runs.follow(going.id, going.verb);
  if (!told) return;
  if (going.verb === "inspect") await opened(told);
  else if (["balance", "recut"].includes(going.verb)) await see.ended(told);
  else if (going.verb === "compare") await board.board(told);
  else if (analyse.known(going.verb)) await analyse.show(told);
});

window.addEventListener("focus", behind(async () => {
  await clash.news();
  state.cranks = (await askJson("/api/cranks")).cranks;
  runs.list((await askJson("/api/runs")).runs);
}));

await guarded(begin)();
document.body.dataset.ready = "true";
