// Where a ray meets a mesh whose triangles lie along a curve that fills space: boxes of runs, boxes of those.
const RUN = 64, RUNS = 16;

export class Rays {
  constructor(corners, triangles) {
    this.p = corners; this.t = triangles;
    this.count = triangles.length / 3;
    this.small = this.boxes(this.count, RUN, (k, grow) => { for (let e = 0; e < 3; e++) { const i = 3 * this.t[3 * k + e]; grow(this.p[i], this.p[i + 1], this.p[i + 2]); } });
    const inner = this.small;
    this.large = this.boxes(inner.length / 6, RUNS, (k, grow) => { grow(inner[6 * k], inner[6 * k + 1], inner[6 * k + 2]); grow(inner[6 * k + 3], inner[6 * k + 4], inner[6 * k + 5]); });
  }

  boxes(count, each, points) {
    const made = new Float32Array(6 * Math.ceil(count / each));
    for (let b = 0; b < made.length; b += 6) {
      let ax = Infinity, ay = Infinity, az = Infinity, bx = -Infinity, by = -Infinity, bz = -Infinity;
      const grow = (x, y, z) => { if (x < ax) ax = x; if (x > bx) bx = x; if (y < ay) ay = y; if (y > by) by = y; if (z < az) az = z; if (z > bz) bz = z; };
      const first = (b / 6) * each;
      for (let k = first; k < Math.min(count, first + each); k++) points(k, grow);
      made.set([ax, ay, az, bx, by, bz], b);
    }
    return made;
  }

  // The nearest hit for which `kept` holds: { triangle, distance, point } or null; `any`: the first that is found.
  cast(origin, way, kept = () => true, any = false) {
    let best = null;
    const small = this.small.length / 6;
    for (let b = 0; b < this.large.length / 6; b++) {
      if (!meets(this.large, 6 * b, origin, way)) continue;
      for (let s = b * RUNS; s < Math.min(small, (b + 1) * RUNS); s++) {
        if (!meets(this.small, 6 * s, origin, way)) continue;
        for (let k = s * RUN; k < Math.min(this.count, (s + 1) * RUN); k++) {
          const distance = this.hit(k, origin, way);
          if (distance === null || (best && distance >= best.distance)) continue;
          const point = origin.map((o, axis) => o + distance * way[axis]);
          if (!kept(point)) continue;
          best = { triangle: k, distance, point };
          if (any) return best;
        }
      }
    }
    return best;
  }

  // Möller and Trumbore, both sides.
  hit(k, o, d) {
    const { p, t } = this, a = 3 * t[3 * k], b = 3 * t[3 * k + 1], c = 3 * t[3 * k + 2];
    const e1x = p[b] - p[a], e1y = p[b + 1] - p[a + 1], e1z = p[b + 2] - p[a + 2];
    const e2x = p[c] - p[a], e2y = p[c + 1] - p[a + 1], e2z = p[c + 2] - p[a + 2];
    const hx = d[1] * e2z - d[2] * e2y, hy = d[2] * e2x - d[0] * e2z, hz = d[0] * e2y - d[1] * e2x;
    const det = e1x * hx + e1y * hy + e1z * hz;
    if (Math.abs(det) < 1e-12) return null;
    const sx = o[0] - p[a], sy = o[1] - p[a + 1], sz = o[2] - p[a + 2];
    const u = (sx * hx + sy * hy + sz * hz) / det;
    if (u < 0 || u > 1) return null;
    const qx = sy * e1z - sz * e1y, qy = sz * e1x - sx * e1z, qz = sx * e1y - sy * e1x;
    const v = (d[0] * qx + d[1] * qy + d[2] * qz) / det;
    if (v < 0 || u + v > 1) return null;
    return (e2x * qx + e2y * qy + e2z * qz) / det;
  }
}

function meets(box, at, o, d) {
  let near = -Infinity, far = Infinity;
  for (let axis = 0; axis < 3; axis++) {
    const low = box[at + axis] - o[axis], high = box[at + 3 + axis] - o[axis];
    if (Math.abs(d[axis]) < 1e-12) { if (low > 0 || high < 0) return false; continue; }
    const one = low / d[axis], two = high / d[axis];
    near = Math.max(near, Math.min(one, two)); far = Math.min(far, Math.max(one, two));
  }
  return near <= far;
}
