// Pieces of the scene: metal, its caps where a section opens it, its edges, rings and the axis, in the scheme's colours.
const T = window.THREE;
export const dark = matchMedia("(prefers-color-scheme: dark)");
const INK = { journal: ["#7aa9d6", "#7aa9d6"], pin: ["#4fb8a9", "#4fb8a9"], weight: ["#d3b878", "#d3b878"], metal: ["#b4bac1", "#b4bac1"], cap: ["#7d8893", "#4a5560"], line: ["#4a5560", "#10151a"], mark: ["#0b5cad", "#7db8f5"], chosen: ["#d9480f", "#ff9f5a"], gone: ["#d9501c", "#d9501c"], zone: ["#12703c", "#6fd39a"], axis: ["#b3261e", "#ff9c94"], heavy: ["#17191c", "#eceded"] };
export const ink = (name) => INK[name][dark.matches ? 1 : 0];

export class Pieces {
  constructor(clip) { this.clip = [clip]; }

  mesh(shape, name, side = T.DoubleSide) {
    return named(new T.Mesh(shape, new T.MeshLambertMaterial({ color: ink(name), flatShading: true, side, clippingPlanes: this.clip, polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1 })), name);
  }
  caps(shape) {
    return named(new T.Mesh(shape, new T.MeshBasicMaterial({ color: ink("cap"), side: T.BackSide, clippingPlanes: this.clip })), "cap");
  }
  lines(ends) { return this.stroked(ends, "line", this.clip); }
  ring(z, radius, name) {
    const ends = [];
    for (let k = 0; k < 96; k++) for (const turn of [k, k + 1]) ends.push(radius * Math.cos((turn * Math.PI) / 48), radius * Math.sin((turn * Math.PI) / 48), z);
    return this.stroked(new Float32Array(ends), name);
  }
  axis([low, high]) { const more = 0.12 * (high - low); return this.stroked(new Float32Array([0, 0, low - more, 0, 0, high + more]), "axis"); }
  stroked(ends, name, clippingPlanes = []) {
    const shape = new T.BufferGeometry();
    shape.setAttribute("position", new T.BufferAttribute(ends, 3));
    return named(new T.LineSegments(shape, new T.LineBasicMaterial({ color: ink(name), clippingPlanes })), name);
  }
}

// What carries the name of its ink is painted anew when the scheme changes.
function named(made, name) { made.userData.ink = name; return made; }
