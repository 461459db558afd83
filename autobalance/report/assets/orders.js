/* Curves of a record: drag to move, wheel or + − to zoom, double click or 0 for all. Data: least and greatest of
   neighbours, in levels, so that a long record is drawn as fast as a short one. */
"use strict";
(() => {
  const bytes = (text) => Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
  const data = JSON.parse(document.getElementById("orders-data").textContent);
  const numbers = (text) => new Float32Array(bytes(text).buffer);

  function levels(low, high) {
    const all = [[low, high]];
    while (all[all.length - 1][0].length > 2000) {
      const [l, h] = all[all.length - 1], n = Math.ceil(l.length / 4);
      const ll = new Float32Array(n), hh = new Float32Array(n);
      for (let k = 0; k < n; k++) {
        let a = Infinity, b = -Infinity;
        for (let j = 4 * k; j < Math.min(4 * k + 4, l.length); j++) { a = Math.min(a, l[j]); b = Math.max(b, h[j]); }
        ll[k] = a; hh[k] = b;
      }
      all.push([ll, hh]);
    }
    return all;
  }

  function ticks(a, b, count) {
    const raw = (b - a) / count, size = 10 ** Math.floor(Math.log10(raw));
    const step = [1, 2, 5, 10].map((m) => m * size).find((s) => s >= raw);
    const found = [];
    for (let v = Math.ceil(a / step) * step; v <= b + 1e-9 * step; v += step) found.push(Math.abs(v) < 1e-9 * step ? 0 : v);
    return found;
  }

  const charts = {};
  for (const canvas of document.querySelectorAll("canvas[data-curve]")) {
    const curve = data[canvas.dataset.curve], all = levels(numbers(curve.low), numbers(curve.high));
    const whole = [curve.first, curve.first + curve.step * all[0][0].length];
    let [from, to] = whole, drag = null;
    const readout = canvas.parentElement.querySelector("output");
    const log = Boolean(curve.log), turn = (v) => (log ? Math.log10(Math.max(v, curve.least)) : v);
    const style = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

    function draw() {
      const ratio = devicePixelRatio || 1, w = canvas.clientWidth, h = canvas.clientHeight;
      canvas.width = w * ratio; canvas.height = h * ratio;
      const pen = canvas.getContext("2d");
      pen.scale(ratio, ratio); pen.font = "11px system-ui, sans-serif";
      const left = 62, right = w - 10, top = 8, bottom = h - 34;
      let level = 0;
      while (level + 1 < all.length && (to - from) / (curve.step * 4 ** (level + 1)) > 2 * (right - left)) level++;
      const [low, high] = all[level], step = curve.step * 4 ** level;
      const a = Math.max(0, Math.floor((from - curve.first) / step) - 1), b = Math.min(low.length - 1, Math.ceil((to - curve.first) / step) + 1);
      let least = Infinity, most = -Infinity;
      for (let k = a; k <= b; k++) { least = Math.min(least, turn(low[k])); most = Math.max(most, turn(high[k])); }
      if (!(most > least)) { most = least + 1; least -= 1; }
      const room = 0.06 * (most - least); least -= room; most += room;
      const x = (t) => left + ((t - from) / (to - from)) * (right - left), y = (v) => bottom - ((turn(v) - least) / (most - least)) * (bottom - top);
      const level_y = (v) => bottom - ((v - least) / (most - least)) * (bottom - top);
      pen.strokeStyle = style("--rule"); pen.fillStyle = style("--soft"); pen.lineWidth = 1;
      pen.textAlign = "center";
      for (const t of ticks(from, to, 8)) { pen.beginPath(); pen.moveTo(x(t), top); pen.lineTo(x(t), bottom); pen.stroke(); pen.fillText(String(+t.toPrecision(7)), x(t), bottom + 14); }
      pen.fillText(curve.x, (left + right) / 2, h - 4);
      pen.textAlign = "right";
      for (const v of ticks(least, most, 5)) { pen.beginPath(); pen.moveTo(left, level_y(v)); pen.lineTo(right, level_y(v)); pen.stroke(); pen.fillText(log ? (10 ** v).toExponential(0) : String(+v.toPrecision(4)), left - 6, level_y(v) + 4); }
      pen.save(); pen.beginPath(); pen.rect(left, top, right - left, bottom - top); pen.clip();
      pen.strokeStyle = style("--accent"); pen.lineWidth = 1.2; pen.beginPath();
      for (let k = a; k <= b; k++) {
        const at = x(curve.first + (k + 0.5 * (level > 0)) * step);
        if (k === a) pen.moveTo(at, y(low[k]));
        pen.lineTo(at, y(low[k])); if (high[k] !== low[k]) pen.lineTo(at, y(high[k]));
      }
      pen.stroke();
      pen.fillStyle = style("--before"); pen.textAlign = "left";
      for (const mark of curve.marks || []) {
        if (mark.at < from || mark.at > to) continue;
        pen.beginPath(); pen.arc(x(mark.at), y(mark.value), 3, 0, 7); pen.fill(); pen.fillText(mark.text, x(mark.at) + 5, y(mark.value) - 4);
      }
      pen.restore();
      readout.textContent = `${(+from.toPrecision(6))} to ${(+to.toPrecision(6))} ${curve.unit}`;
    }

    function look(a, b) {
      const least = 8 * curve.step, width = Math.min(Math.max(b - a, least), whole[1] - whole[0]);
      const middle = (a + b) / 2;
      from = Math.min(Math.max(middle - width / 2, whole[0]), whole[1] - width); to = from + width; draw();
    }
    const at = (event) => from + ((event.offsetX - 62) / (canvas.clientWidth - 72)) * (to - from);
    const zoom = (factor, t) => look(t - (t - from) * factor, t + (to - t) * factor);
    canvas.addEventListener("wheel", (event) => { event.preventDefault(); zoom(Math.exp(event.deltaY * 0.0015), at(event)); }, { passive: false });
    canvas.addEventListener("pointerdown", (event) => { drag = [event.clientX, from, to]; canvas.setPointerCapture(event.pointerId); });
    canvas.addEventListener("pointermove", (event) => { if (drag) { const move = ((drag[0] - event.clientX) / (canvas.clientWidth - 72)) * (drag[2] - drag[1]); look(drag[1] + move, drag[2] + move); } });
    canvas.addEventListener("pointerup", () => { drag = null; });
    canvas.addEventListener("dblclick", () => look(...whole));
    canvas.addEventListener("keydown", (event) => {
      const middle = (from + to) / 2, tenth = (to - from) / 10;
      const keys = { "+": () => zoom(0.6, middle), "-": () => zoom(1 / 0.6, middle), "0": () => look(...whole), ArrowLeft: () => look(from - tenth, to - tenth), ArrowRight: () => look(from + tenth, to + tenth) };
      if (keys[event.key]) { event.preventDefault(); keys[event.key](); }
    });
    new ResizeObserver(draw).observe(canvas);
    charts[canvas.dataset.curve] = { look, range: () => [from, to] };
  }
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => Object.values(charts).forEach((chart) => chart.look(...chart.range())));
  // for tests and for scripts that drive the page
  window.autobalanceOrders = charts;
})();
