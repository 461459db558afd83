// A number as it was measured: its report's key and all its digits are there for programs and tests.
import { html } from "/static/preact.min.js";
import { shown } from "/static/tools.js";
import { unitOf, unitOfKey } from "/static/units.js";

export function Measured({ of, value, digits = 2, named = false }) {
  const unit = unitOfKey(of), words = named && unit ? ` ${unitOf(unit)}` : "";
  if (value === null || value === undefined) return html`<span>${shown(value)}</span>`;
  return html`<span><span data-key=${of} data-value=${String(value)}>${shown(value, digits, unit)}</span>${words}</span>`;
}
// A number that is predicted says so; a share is shown in percent.
export function Predicted({ value, digits = 2, unit = "" }) {
  const isShare = unit === "%";
  return html`<span class="predicted" data-predicted=${String(value)}>${isShare ? shown(100 * value, digits) : shown(value, digits, unit)}</span>`;
}
