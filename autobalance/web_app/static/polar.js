// Unbalance as arrows across the axis, with the circle that is permitted: crankpin 1 up, angles counter-clockwise.
const NS = "http://www.w3.org/2000/svg";
const RADIUS = 70, MIDDLE = 100;

function svg(name, values, text) {
  const made = document.createElementNS(NS, name);
  for (const [key, value] of Object.entries(values)) made.setAttribute(key, String(value));
  if (text !== undefined) made.textContent = text;
  return made;
}

// A plot for each unbalance, before or after, in the scale that shows both it and what is permitted.
export function polar(title, vectors, permitted) {
  const figure = document.createElement("figure"), caption = document.createElement("figcaption"), pair = document.createElement("div");
  caption.textContent = title;
  pair.className = "pair";
  pair.append(...vectors.map((each) => plot(title, each, permitted)));
  figure.append(caption, pair);
  return figure;
}

function plot(title, { unbalance_g_mm: xy, magnitude_g_mm: size, name: when }, permitted) {
  const per = RADIUS / Math.max(size, 1.05 * permitted, 1e-9);
  const made = svg("svg", { viewBox: "0 0 200 206", role: "img", "aria-label": `${title}: ${when} ${size.toFixed(2)} g·mm; permitted ${permitted.toFixed(2)} g·mm` });
  made.append(svg("circle", { class: "grid", cx: MIDDLE, cy: MIDDLE, r: RADIUS }), svg("path", { class: "grid", d: `M${MIDDLE} ${MIDDLE - RADIUS}v${2 * RADIUS}M${MIDDLE - RADIUS} ${MIDDLE}h${2 * RADIUS}` }));
  made.append(svg("circle", { class: "permitted", cx: MIDDLE, cy: MIDDLE, r: Math.max(1, per * permitted) }));
  for (const [degrees, x, y] of [[0, MIDDLE, 22], [90, 12, 104], [180, MIDDLE, 186], [270, 188, 104]]) made.append(svg("text", { x, y, "text-anchor": "middle" }, `${degrees}°`));
  const x = MIDDLE - per * xy[1], y = MIDDLE - per * xy[0];
  made.append(svg("path", { class: `vector ${when}`, d: `M${MIDDLE} ${MIDDLE}L${x.toFixed(2)} ${y.toFixed(2)}` }), svg("circle", { class: `tip ${when}`, cx: x.toFixed(2), cy: y.toFixed(2), r: 4 }));
  made.append(svg("text", { class: "when", x: MIDDLE, y: 203, "text-anchor": "middle" }, `${when} ${size.toFixed(2)} g·mm`));
  return made;
}
