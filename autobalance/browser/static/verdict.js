// Verdict of a result: outcome, proven and current in one place, for every part of the page that says it.
import { state } from "/static/job.js";
import { labelOf } from "/static/said.js";
import { shown, withUnit } from "/static/tools.js";
import { t } from "/static/words.js";

const OUTCOMES = { within_tolerance: "Within tolerance", already_within_tolerance: "Already within tolerance", above_tolerance: "Above tolerance" };

// Tone, words and the sentence of a result; null where there is none.
export function judged() {
  const { report, told } = state.result || {};
  return report ? judgement(report, told) : null;
}
export function judgement(report, told) {
  const isAbove = report.outcome === "above_tolerance", isUnproven = !isAbove && report.proven === false;
  const tone = told?.job_changed ? "stale" : isAbove ? "bad" : isUnproven ? "warn" : "good";
  const isLater = report.outcome === "already_within_tolerance" && report.stages?.length > 0; // earlier stages were cut
  const words = isUnproven ? t("Within, not proven") : t(OUTCOMES[isLater ? "within_tolerance" : report.outcome]);
  return { tone, words: tone === "stale" ? t("Earlier result: {verdict}", { verdict: words.toLocaleLowerCase() }) : words, says: sentence(report), why: isUnproven ? t("Residual and uncertainty together exceed the permissible unbalance.") : "", changes: tone === "stale" ? told.changes : [] };
}

// Where an unbalance is judged: the resultant, then each plane, each with what is permitted there.
export const places = (what, tolerance) => [[t("Resultant"), what, tolerance.permissible_g_mm], ...what.planes.map((plane, k) => [`${t("Plane")} ${plane.name}`, plane, tolerance.planes[k].permissible_g_mm])];
// The place that decides: with its uncertainty the nearest to what is permitted there, or the furthest above.
export function deciding(what, tolerance) {
  const share = ([, { magnitude_g_mm: size, uncertainty_g_mm: off }, permitted]) => (size + (off || 0)) / permitted;
  return places(what, tolerance).reduce((most, each) => (share(each) > share(most) ? each : most));
}

// A verdict that is not met tells of the place that decides: the resultant alone may be within.
export function judgedAt(report) {
  const isMissed = report.outcome === "above_tolerance" || report.proven === false;
  return isMissed ? deciding(report.residual, report.tolerance) : places(report.residual, report.tolerance)[0];
}
function sentence(report) {
  const { residual, tolerance } = report, [place, found, limit] = judgedAt(report), U = found.uncertainty_g_mm;
  const left = typeof U === "number" ? `${shown(found.magnitude_g_mm, 2, "g·mm")} ± ${withUnit(U, 2, "g·mm")}` : withUnit(found.magnitude_g_mm, 2, "g·mm");
  const given = { left, permitted: withUnit(limit, 2, "g·mm"), grade: tolerance.grade_mm_s, speed: tolerance.speed_rpm };
  const says = typeof tolerance.grade_mm_s === "number" ? t("Residual {left}; G {grade} permits {permitted} at {speed} rpm.", given) : t("Residual {left}; {permitted} is permitted.", given);
  return found === residual ? says : `${place}: ${says}`;
}

const valueOf = (value) => (value === null || value === undefined ? t("not set") : typeof value === "number" ? shown(value, Number.isInteger(value) ? 0 : 2) : typeof value === "object" ? Object.values(value).join("; ") : String(value));
export const changeText = ({ key, was, now }) => `${labelOf(key)}: ${valueOf(was)} → ${valueOf(now)}`;
