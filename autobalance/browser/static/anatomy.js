// Journals, crankpins and counterweights in colours of their own: triangles over those of the metal, cut where a counterweight ends.
const ON_ROUND = 0.02; // corners off a cylinder by less than this share of its radius lie on it

// Of a mesh, the corners of the triangles of each ink; `anatomy`: { journals, pins: [[x, y, z, radius, width]], weights: [[z from, z to, x, y away from the crankpin]] }.
export function ofAnatomy(corners, rows, { journals, pins, weights }) {
  const found = { journal: [], pin: [], weight: [] }, p = [0, 1, 2].map(() => [0, 0, 0]), round = [["journal", journals], ["pin", pins]];
  for (let k = 0; k < rows.length; k += 3) {
    for (let e = 0; e < 3; e++) for (let axis = 0; axis < 3; axis++) p[e][axis] = corners[3 * rows[k + e] + axis];
    const low = Math.min(p[0][2], p[1][2], p[2][2]), high = Math.max(p[0][2], p[1][2], p[2][2]);
    const on = round.find(([, all]) => all.some((each) => isOn(p, low, high, each)));
    if (on) { found[on[0]].push(...p.flat()); continue; }
    const middle = (p[0][2] + p[1][2] + p[2][2]) / 3, within = weights.find(([from, to]) => middle > from - 1e-3 && middle < to + 1e-3);
    if (within) beyond(p, within[2], within[3], found.weight);
  }
  return Object.fromEntries(Object.entries(found).map(([name, list]) => [name, new Float32Array(list)]));
}

// The diameter of the journal or crankpin on which a point lies; null elsewhere.
export function roundOf([x, y, z], anatomy) {
  const found = anatomy && [...anatomy.journals, ...anatomy.pins].find(([a, b, c, radius, width]) => Math.abs(z - c) < width / 2 + ON_ROUND * radius && Math.abs(Math.hypot(x - a, y - b) - radius) < ON_ROUND * radius);
  return found ? 2 * found[3] : null;
}

function isOn(p, low, high, [x, y, z, radius, width]) {
  const slack = ON_ROUND * radius;
  if (low < z - width / 2 - slack || high > z + width / 2 + slack || high - low < 1e-3 * radius) return false;
  return p.every(([a, b]) => Math.abs(Math.hypot(a - x, b - y) - radius) < slack);
}

// The part of a triangle on one side of a plane through the axis.
function beyond(p, x, y, list) {
  const far = p.map((each) => each[0] * x + each[1] * y), left = [];
  for (let e = 0; e < 3; e++) {
    const next = (e + 1) % 3;
    if (far[e] >= 0) left.push(p[e]);
    if (far[e] * far[next] < 0) { const share = far[e] / (far[e] - far[next]); left.push(p[e].map((value, axis) => value + share * (p[next][axis] - value))); }
  }
  for (let e = 2; e < left.length; e++) list.push(...left[0], ...left[e - 1], ...left[e]);
}
