// A number as it was measured: its report's key and all its digits are there for programs and tests.
import { html } from "/static/preact.min.js";
import { shown } from "/static/tools.js";
import { unitOf, unitOfKey } from "/static/units.js";

// `sign` -1: what the report has below zero, as metal that is added, is shown as an amount.
export function Measured({ of, value, digits = 2, named = false, sign = 1 }) {
  const unit = unitOfKey(of), words = named && unit ? ` ${unitOf(unit)}` : "";
  if (value === null || value === undefined) return html`<span>${shown(value)}</span>`;
  return html`<span><span data-key=${of} data-value=${String(value)}>${shown(sign * value, digits, unit)}</span>${words}</span>`;
}
// A number that is predicted says so; a share is shown in percent.
export function Predicted({ value, digits = 2, unit = "" }) {
  const isShare = unit === "%";
  return html`<span class="predicted" data-predicted=${String(value)}>${isShare ? shown(100 * value, digits) : shown(value, digits, unit)}</span>`;
}
