// Unbalance as arrows across the axis, with the circle that is permitted: crankpin 1 up, angles counter-clockwise.
const NS = "http://www.w3.org/2000/svg";
const RADIUS = 70, MIDDLE = 100;

function svg(name, values, text) {
  const made = document.createElementNS(NS, name);
  for (const [key, value] of Object.entries(values)) made.setAttribute(key, String(value));
  if (text !== undefined) made.textContent = text;
  return made;
}

// One plot: unbalances with their names, before or after, and what is permitted.
export function polar(title, vectors, permitted) {
  const sizes = vectors.map(({ magnitude_g_mm }) => magnitude_g_mm);
  const full = Math.max(...sizes, 1.05 * permitted, 1e-9), per = RADIUS / full;
  const words = vectors.map(({ name }, k) => `${name} ${sizes[k].toFixed(2)} g·mm`).join(", ");
  const plot = svg("svg", { viewBox: "0 0 200 200", role: "img", "aria-label": `${title}: ${words}; permitted ${permitted.toFixed(2)} g·mm` });
  plot.append(svg("circle", { class: "grid", cx: MIDDLE, cy: MIDDLE, r: RADIUS }), svg("path", { class: "grid", d: `M${MIDDLE} ${MIDDLE - RADIUS}v${2 * RADIUS}M${MIDDLE - RADIUS} ${MIDDLE}h${2 * RADIUS}` }));
  plot.append(svg("circle", { class: "permitted", cx: MIDDLE, cy: MIDDLE, r: Math.max(1, per * permitted) }));
  for (const [degrees, x, y] of [[0, MIDDLE, 20], [90, 13, 104], [180, MIDDLE, 189], [270, 187, 104]]) plot.append(svg("text", { x, y, "text-anchor": "middle" }, `${degrees}°`));
  vectors.forEach(({ unbalance_g_mm: xy, name: when }) => {
    const x = MIDDLE - per * xy[1], y = MIDDLE - per * xy[0];
    plot.append(svg("path", { class: `vector ${when}`, d: `M${MIDDLE} ${MIDDLE}L${x.toFixed(2)} ${y.toFixed(2)}` }), svg("circle", { class: `tip ${when}`, cx: x.toFixed(2), cy: y.toFixed(2), r: 4 }));
  });
  const figure = document.createElement("figure"), caption = document.createElement("figcaption");
  caption.textContent = title;
  figure.append(caption, plot);
  return figure;
}
