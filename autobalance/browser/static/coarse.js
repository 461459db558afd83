// For where drawing is slow: a coarse copy of a mesh, to be turned.
const CELLS = 56; // along the longest side
const FEW = 24_000; // triangles that are worth no copy

// Corners that share a cell of a grid become the first of them: rows without the triangles that collapse.
export function coarsened(corners, triangles) {
  if (triangles.length <= 3 * FEW) return triangles;
  const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
  for (let k = 0; k < corners.length; k++) { const axis = k % 3; if (corners[k] < low[axis]) low[axis] = corners[k]; if (corners[k] > high[axis]) high[axis] = corners[k]; }
  const per = CELLS / (Math.max(high[0] - low[0], high[1] - low[1], high[2] - low[2]) || 1), cells = CELLS + 1;
  const first = new Int32Array(cells ** 3).fill(-1), stands = new Uint32Array(corners.length / 3);
  for (let k = 0; k < stands.length; k++) {
    const cell = Math.floor((corners[3 * k] - low[0]) * per) + cells * (Math.floor((corners[3 * k + 1] - low[1]) * per) + cells * Math.floor((corners[3 * k + 2] - low[2]) * per));
    if (first[cell] < 0) first[cell] = k;
    stands[k] = first[cell];
  }
  const rows = new Uint32Array(triangles.length);
  let count = 0;
  for (let k = 0; k < triangles.length; k += 3) {
    const a = stands[triangles[k]], b = stands[triangles[k + 1]], c = stands[triangles[k + 2]];
    if (a !== b && b !== c && c !== a) { rows[count++] = a; rows[count++] = b; rows[count++] = c; }
  }
  return rows.slice(0, count);
}

// How far corners are from a middle along ways, to either side.
export function extents(p, middle, ways) {
  const most = ways.map(() => 1e-9);
  for (let k = 0; k < p.length; k += 3) for (let w = 0; w < ways.length; w++) {
    const [x, y, z] = ways[w], far = Math.abs((p[k] - middle[0]) * x + (p[k + 1] - middle[1]) * y + (p[k + 2] - middle[2]) * z);
    if (far > most[w]) most[w] = far;
  }
  return most;
}
// How far a crank reaches from its axis, and where its webs begin and end.
export function reached(p) {
  const size = { radius: 0, z: [Infinity, -Infinity] };
  for (let k = 0; k < p.length; k += 3) size.radius = Math.max(size.radius, Math.hypot(p[k], p[k + 1]));
  for (let k = 0; k < p.length; k += 3) if (Math.hypot(p[k], p[k + 1]) > 0.6 * size.radius) size.z = [Math.min(size.z[0], p[k + 2]), Math.max(size.z[1], p[k + 2])];
  return size;
}

// Whether the processor draws, without a graphics card: smooth edges then cost more than a finer picture at rest.
export function drawnBySoftware() {
  const gl = document.createElement("canvas").getContext("webgl2"), told = gl?.getExtension("WEBGL_debug_renderer_info");
  const name = told ? gl.getParameter(told.UNMASKED_RENDERER_WEBGL) : "";
  gl?.getExtension("WEBGL_lose_context")?.loseContext();
  return /swiftshader|llvmpipe|softpipe|software|basic render/i.test(name);
}
