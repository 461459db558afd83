// The zero of a job's angles: its keyway or dowel where it has one, else crankpin 1; the papers count from the same.
import { state } from "/static/job.js";
import { shown } from "/static/tools.js";
import { t } from "/static/words.js";

const SIGNS = { keyway: "K", flange_hole: "H" };
const WORDS = { keyway: "keyway", flange_hole: "flange hole" };
const datum = () => (state.result?.report || state.inspected?.report)?.crank?.datums?.angle || null;

// Angle of the zero from crankpin 1 [deg], and how it is written beside a number.
export const zeroDeg = () => datum()?.angle_deg ?? 0;
export const sign = () => `${SIGNS[datum()?.of] || "P1"}↺`;
export const zeroWords = () => t("0° at {zero}, counter-clockwise seen from +z", { zero: t(WORDS[datum()?.of] || "crankpin 1") });
const wrapped = (angle) => ((angle % 360) + 360) % 360;
export const fromZero = (angle) => { const turned = wrapped(angle - zeroDeg()); return turned > 359.9999 ? 0 : turned; };
export const angleText = (angle, digits = 1) => `${shown(fromZero(angle), digits).replace(/^360([.,]0*)?$/, (whole, rest = "") => `0${rest}`)}°`;
