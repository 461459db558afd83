// The crank in 3D, drawn with three.js in rotor or file axes: what is shown, the camera, when it is drawn, and what lies where one points.
import { unpacked } from "/static/buffers.js";
import { ofAnatomy, roundOf } from "/static/anatomy.js";
import { Rays } from "/static/picking.js";
import { coarsened, drawnBySoftware, extents, reached } from "/static/coarse.js";
import { Pieces, dark, ink } from "/static/pieces.js";

const T = window.THREE;
const LATE_MS = 50; // a frame that comes later than this after it was asked for is late
const LATE_FRAMES = 2; // so many of them in a row: from then on less is drawn while the view turns
const HAIR_MM = 0.05; // metal nearer to a point than this is where it lies, not before it
const FILLS = 0.82, REACHES = 0.92; // of half the view: how far the crank, and what stands beside it, reach where they are fitted
const REST_MS = 160; // after so long without a turn the view rests, and is drawn whole

export class View {
  constructor(box, canvas, note) {
    this.box = box; this.note = note; this.clip = new T.Plane(new T.Vector3(-1, 0, 0), 1e9); this.pieces = new Pieces(this.clip);
    this.sets = {}; this.parts = []; this.isRough = false; this.beside = []; this.mode = "crank"; this.onpick = null; this.marked = []; this.words = (words) => words; // in the reader's language
    try {
      this.software = drawnBySoftware();
      this.renderer = new T.WebGLRenderer({ canvas, antialias: !this.software, alpha: true });
    } catch {
      note.textContent = "This browser shows no 3D; everything else works";
      return;
    }
    this.scene = new T.Scene();
    this.sun = new T.DirectionalLight(0xffffff, 2.0); this.fill = new T.DirectionalLight(0xffffff, 0.9);
    this.scene.add(new T.AmbientLight(0xffffff, 0.9), this.sun, this.fill, this.sun.target, this.fill.target);
    this.marks = new T.Group(); this.zones = new T.Group();
    this.scene.add(this.marks, this.zones);
    this.camera = new T.OrthographicCamera(-1, 1, 1, -1, -1e4, 1e4);
    this.camera.up.set(1, 0, 0);
    this.controls = new T.OrbitControls(this.camera, canvas);
    this.controls.enableDamping = false;
    this.controls.addEventListener("change", () => { if (this.held) this.turned(); else this.draw(); });
    this.controls.addEventListener("start", () => { this.held = true; });
    this.controls.addEventListener("end", () => { this.held = false; if (this.turning) this.restSoon(); });
    new ResizeObserver(() => this.resize()).observe(box);
    box.addEventListener("keydown", (event) => this.key(event));
    let down = null;
    canvas.addEventListener("pointerdown", (event) => { down = [event.clientX, event.clientY]; });
    canvas.addEventListener("pointerup", (event) => {
      if (down && Math.hypot(event.clientX - down[0], event.clientY - down[1]) < 4) this.onpick?.(this.pick(event.clientX, event.clientY));
      down = null;
    });
    dark.addEventListener("change", () => this.paint());
  }

  // --- what is shown --------------------------------------------------------------------------------------

  // A crank as it was opened, with the part of each triangle; `whole`: nothing more of it is to come.
  showCrank(buffer, whole = true) {
    const { head, arrays } = unpacked(buffer);
    this.parts = head.parts;
    this.whole = whole;
    this.count = arrays.triangles.length / 3;
    if (!this.renderer) { this.ready(); return; }
    const positions = new T.BufferAttribute(arrays.corners, 3);
    const body = new T.BufferGeometry();
    body.setAttribute("position", positions);
    body.setIndex(new T.BufferAttribute(arrays.triangles, 1));
    this.part = arrays.part;
    this.positions = positions;
    this.rays = new Rays(arrays.corners, arrays.triangles);
    this.put("crank", body, [this.pieces.lines(arrays.edges)], this.count);
    if (whole) this.coloured("crank", head.anatomy);
    this.use("crank");
    this.look();
  }

  // Journals, crankpins and counterweights in their own colours, as everywhere.
  coloured(name, anatomy) {
    const set = this.sets[name];
    set.anatomy = anatomy;
    set.own = anatomy ? this.overlay(set.fine[0].geometry, anatomy) : [];
    if (set.own.length) set.group.add(...set.own);
  }
  overlay(shape, anatomy) {
    return Object.entries(ofAnatomy(shape.attributes.position.array, shape.index.array, anatomy)).filter(([, corners]) => corners.length).map(([ink, corners]) => {
      const own = new T.BufferGeometry();
      own.setAttribute("position", new T.BufferAttribute(corners, 3));
      const made = this.pieces.mesh(own, ink, T.FrontSide);
      made.material.polygonOffsetFactor = 0; made.material.polygonOffsetUnits = 0;
      return made;
    });
  }

  // A crank as a run left it, and the metal that went.
  showResult(buffer) {
    const { head, arrays } = unpacked(buffer), data = head.view;
    if (!this.renderer) { this.count = head.triangles; this.ready(); return; }
    const part = (packed) => {
      const places = new Uint16Array(arrays.meshes.buffer, arrays.meshes.byteOffset + packed.vertices[0], 3 * packed.vertices[1]);
      const shape = new T.BufferGeometry();
      shape.setAttribute("position", new T.BufferAttribute(Float32Array.from(places, (value, k) => data.low_mm[k % 3] + data.step_mm * value), 3));
      shape.setIndex(new T.BufferAttribute(new Uint32Array(arrays.meshes.buffer, arrays.meshes.byteOffset + packed.triangles[0], 3 * packed.triangles[1]), 1));
      return shape;
    };
    const body = part(data.body);
    this.bodyRays = new Rays(body.attributes.position.array, body.index.array);
    this.metal = new T.Group();
    const floors = new T.Group();
    for (const piece of data.pieces) {
      const skin = this.pieces.mesh(part(piece.skin), "gone");
      skin.material.transparent = true;
      const floor = this.pieces.mesh(part(piece.floor), "gone");
      Object.assign(floor.material, { polygonOffset: true, polygonOffsetFactor: -1, polygonOffsetUnits: -2 });
      skin.userData.number = floor.userData.number = piece.number;
      this.metal.add(skin); floors.add(floor);
    }
    const rings = data.tolerance_planes.map((plane) => this.pieces.ring(plane.z_mm, 1.1 * data.radius_mm, "zone"));
    this.floors = floors;
    this.put("result", body, [this.pieces.lines(arrays.edges), this.metal, floors, ...rings, this.pieces.axis(data.z_mm)], head.triangles);
    this.coloured("result", head.anatomy);
    this.result = data;
    this.whole = true;
    this.use("result");
    this.look();
  }

  put(name, body, others, triangles) {
    this.rough(false);
    if (this.sets[name]) { this.scene.remove(this.sets[name].group); this.sets[name].group.traverse((each) => { each.geometry?.dispose(); each.material?.dispose(); }); }
    const group = new T.Group(), fine = [this.pieces.mesh(body, "metal", T.FrontSide), this.pieces.caps(body), others[0]];
    group.add(...fine, ...others.slice(1));
    body.computeBoundingSphere();
    this.scene.add(group);
    this.sets[name] = { group, fine, own: [], coarse: null, sphere: body.boundingSphere, triangles };
    this.slow = this.software; this.late = 0;
  }

  clear() {
    this.rough(false);
    for (const name of Object.keys(this.sets)) this.scene.remove(this.sets[name].group);
    this.sets = {}; this.parts = []; this.rays = null;
    this.marks?.clear(); this.zones?.clear();
    Object.assign(this.box.dataset, { state: "empty", triangles: "0" });
    this.whole = true;
    this.say("No crank yet");
    this.draw();
  }
  say(words) { this.note.textContent = this.words(words); }

  use(name) {
    if (!this.sets[name]) return;
    this.mode = name;
    for (const [each, set] of Object.entries(this.sets)) set.group.visible = each === name;
    this.marks.visible = this.zones.visible = name === "crank";
    this.count = this.sets[name].triangles;
    this.section(this.cut?.[0] || "none", this.cut?.[1] ?? 0.5);
    this.ready();
    this.draw();
  }

  ready() {
    this.box.dataset.triangles = String(this.count);
    this.box.dataset.state = this.whole ? "ready" : "loading";
    if (this.renderer) this.say(this.whole ? "" : "What is what is being found out");
  }

  // How much of the metal that went is still shown, 1 to 0.
  fade(share) {
    if (!this.metal) return;
    for (const each of this.metal.children) { each.material.opacity = share; each.visible = share > 0.01; each.material.depthWrite = share > 0.99; }
    this.draw();
  }

  // Show a cut's metal where a hand has dragged it: `by` mm along `way`, turned about the axis, `wide` times as wide
  // about its `middle`; or a rim at `scale`.
  moved(number, { by, way, turn, scale, wide, middle }) {
    const about = new T.Vector3(0, 0, 1), still = !by && !turn && wide === 1;
    for (const each of [...(this.floors?.children || []), ...(this.metal?.children || [])]) {
      if (each.userData.number !== number) continue;
      const floor = each.parent === this.floors;
      each.rotation.z = turn;
      if (floor && scale === null) {
        each.scale.setScalar(wide);
        each.position.set(...way).multiplyScalar(by).addScaledVector(new T.Vector3(...middle), 1 - wide).applyAxisAngle(about, turn);
      }
      if (floor && scale !== null) each.scale.set(scale, scale, 1);
      if (!floor) continue;
      each.userData.ink = still ? "gone" : "chosen";
      each.material.color.set(ink(each.userData.ink));
      Object.assign(each.material, { depthTest: still, transparent: !still, opacity: still ? 1 : 0.8 });
      each.renderOrder = still ? 0 : 2;
    }
    if (this.held) this.turned(); else this.draw(); // a hand moves it: coarse where frames come late
  }

  section(axis, share) {
    this.cut = [axis, share];
    const sphere = this.sets[this.mode]?.sphere;
    if (!sphere) return null;
    const ways = { x: [-1, 0, 0], y: [0, -1, 0], z: [0, 0, -1] };
    const place = axis === "none" ? 1e9 : sphere.center[axis] + (2 * share - 1) * sphere.radius;
    this.clip.set(new T.Vector3(...(ways[axis] || ways.z)), place);
    this.clipped(axis !== "none");
    this.draw();
    return axis === "none" ? null : place;
  }

  // Only where a section is on is every pixel asked on which side of it it lies: that takes long to draw.
  clipped(on) {
    this.renderer.localClippingEnabled = on;
    for (const set of Object.values(this.sets)) {
      set.fine[1].visible = on; // caps: seen through a cut only
      if (set.coarse) set.coarse.children[1].visible = on;
    }
  }

  // --- marks ----------------------------------------------------------------------------------------------

  // Colour parts, by their places in `parts`, from 1.
  mark(chosen, colour = "chosen") {
    if (!this.renderer || !this.rays) return;
    this.marked = [chosen, colour];
    for (const each of [...this.marks.children]) { this.marks.remove(each); each.geometry.dispose(); each.material.dispose(); }
    const wanted = new Set(chosen), rows = [], t = this.rays.t;
    if (wanted.size) for (let k = 0; k < this.part.length; k++) if (wanted.has(this.part[k])) rows.push(t[3 * k], t[3 * k + 1], t[3 * k + 2]);
    if (rows.length) {
      const shape = new T.BufferGeometry();
      shape.setAttribute("position", this.positions);
      shape.setIndex(new T.BufferAttribute(new Uint32Array(rows), 1));
      const made = this.pieces.mesh(shape, colour);
      Object.assign(made.material, { polygonOffset: true, polygonOffsetFactor: -1, polygonOffsetUnits: -2 });
      this.marks.add(made);
    }
    this.draw();
  }

  // A ring about the axis: a journal, a throw, a web.
  point(centre, radius) {
    if (!this.renderer || !this.sets.crank) return;
    if (this.pointer) { this.scene.remove(this.pointer); this.pointer = null; }
    if (centre) {
      this.pointer = new T.Mesh(new T.RingGeometry(radius, radius + 0.03 * this.sets.crank.sphere.radius, 72), new T.MeshBasicMaterial({ color: ink("mark"), side: T.DoubleSide, depthTest: false, transparent: true, opacity: 0.85 }));
      this.pointer.position.set(...centre);
      this.pointer.renderOrder = 2;
      this.scene.add(this.pointer);
    }
    this.draw();
  }

  // Angles where metal may go, about the crank axis: [[from, to], ...] in degrees.
  sectors(zones) {
    if (!this.renderer || !this.sets.crank) return;
    this.zones.clear();
    const { center, radius } = this.sets.crank.sphere;
    for (const [from, to] of zones) {
      const span = ((to - from) % 360 + 360) % 360 || 360;
      const fan = new T.Mesh(new T.RingGeometry(0.2 * radius, 0.8 * radius, 72, 1, (from * Math.PI) / 180, (span * Math.PI) / 180), new T.MeshBasicMaterial({ color: ink("zone"), side: T.DoubleSide, transparent: true, opacity: 0.35, depthWrite: false }));
      fan.position.z = center.z;
      this.zones.add(fan);
    }
    this.draw();
  }

  paint() {
    this.scene?.traverse((each) => { if (each.userData.ink) each.material.color.set(ink(each.userData.ink)); });
    this.draw();
  }

  // --- camera ---------------------------------------------------------------------------------------------

  look() {
    const { center, radius } = this.sets[this.mode].sphere;
    this.radius = this.mode === "result" ? 1.2 * radius : radius; // with the rings of the tolerance planes
    this.controls.target.copy(center);
    this.camera.position.copy(center).add(new T.Vector3(0.9 * radius, 1.6 * radius, 1.9 * radius));
    this.controls.update();
    this.resize();
    this.fit();
  }
  // The crank fills the view as it is seen now; what a hand has zoomed stays.
  fit() {
    const [wide, high] = [[this.corners(), FILLS], [this.beside, REACHES]].map(([p, share]) => extents(p, this.controls.target.toArray(), this.axes()).map((far) => far / share)).reduce((one, other) => one.map((far, k) => Math.max(far, other[k])));
    this.fitted = this.camera.zoom = (this.room || 1) * Math.min(this.camera.right / wide, this.camera.top / high);
    this.camera.updateProjectionMatrix();
    this.draw();
  }
  corners() { return this.sets[this.mode].fine[0].geometry.attributes.position.array; }

  // Look against a direction that points out of the metal, a little from aside; `aside` null: square on.
  turnTo(out, aside = [0, 0, 0.45]) {
    if (!this.renderer || !this.sets[this.mode]) return;
    const away = new T.Vector3(...out).normalize();
    if (aside) away.add(new T.Vector3(...(Math.abs(away.z) > 0.9 ? [0.3, 0.25, 0] : aside))).normalize();
    this.camera.position.copy(this.controls.target).addScaledVector(away, 2.6 * this.radius);
    this.controls.update();
    if (this.camera.zoom === this.fitted) this.fit();
    this.draw();
  }

  key(event) {
    const turn = { ArrowLeft: [-0.12, 0], ArrowRight: [0.12, 0], ArrowUp: [0, -0.12], ArrowDown: [0, 0.12] }[event.key];
    const zoom = { "+": 1.15, "=": 1.15, "-": 1 / 1.15 }[event.key];
    if ((!turn && !zoom) || !this.sets[this.mode]) return;
    if (zoom) { this.camera.zoom = Math.min(30, Math.max(0.4, this.camera.zoom * zoom)); this.camera.updateProjectionMatrix(); }
    else {
      const away = this.camera.position.clone().sub(this.controls.target);
      const side = new T.Vector3().copy(this.camera.up).cross(away).normalize();
      away.applyAxisAngle(this.camera.up, turn[0]).applyAxisAngle(side, turn[1]);
      this.camera.position.copy(this.controls.target).add(away);
    }
    this.controls.update();
    this.turned();
    event.preventDefault();
  }

  resize() {
    const { clientWidth: width, clientHeight: height } = this.box;
    if (!this.renderer || !width || !height) return;
    this.renderer.setPixelRatio(this.density());
    this.renderer.setSize(width, height, false);
    const half = 1.05 * (this.radius || 1), aspect = width / height;
    Object.assign(this.camera, { left: -half * Math.max(1, aspect), right: half * Math.max(1, aspect), top: half * Math.max(1, 1 / aspect), bottom: -half * Math.max(1, 1 / aspect) });
    this.camera.updateProjectionMatrix();
    this.controls.update();
    if (this.sets[this.mode] && this.camera.zoom === this.fitted) this.fit();
    this.draw();
  }

  draw() {
    if (!this.renderer || this.waiting) return;
    this.waiting = true;
    const asked = performance.now();
    requestAnimationFrame(() => {
      this.waiting = false;
      if (this.turning) this.paced(performance.now() - asked);
      this.drawn();
      if (this.turning) this.restSoon();
    });
  }

  // --- while it turns -------------------------------------------------------------------------------------

  // A turn: where frames come late, as without a graphics card, a coarse copy until it rests.
  turned() {
    if (!this.sets[this.mode]) return;
    this.turning = true;
    if (this.slow) this.rough(true);
    this.draw();
  }
  restSoon() {
    clearTimeout(this.resting);
    this.resting = setTimeout(() => {
      if (this.held || this.waiting) return; // a hand is on it; or the next frame sees to it
      this.turning = false;
      this.rough(false);
      this.draw();
    }, REST_MS);
  }
  paced(late) {
    this.late = late > LATE_MS ? this.late + 1 : 0;
    if (this.late >= LATE_FRAMES) this.slow = true;
  }
  rough(on) {
    if (this.isRough === on) return;
    this.isRough = on;
    const set = this.sets[this.mode];
    if (on && !set.coarse) set.coarse = this.coarse(set);
    for (const each of Object.values(this.sets)) {
      if (!each.coarse) continue;
      each.coarse.visible = on;
      each.fine[0].visible = each.fine[2].visible = !on;
      each.fine[1].visible = !on && this.renderer.localClippingEnabled;
      for (const own of each.own) own.visible = !on;
    }
    this.renderer.setPixelRatio(this.density());
  }
  coarse(set) {
    const { index, attributes } = set.fine[0].geometry, rows = coarsened(attributes.position.array, index.array);
    const shape = new T.BufferGeometry(), made = new T.Group();
    shape.setAttribute("position", attributes.position);
    shape.setIndex(new T.BufferAttribute(rows, 1));
    made.add(this.pieces.mesh(shape, "metal", T.FrontSide), this.pieces.caps(shape));
    made.children[1].visible = this.renderer.localClippingEnabled;
    if (set.own.length) made.add(...this.overlay(shape, set.anatomy));
    set.group.add(made);
    return made;
  }
  density() { return Math.min((this.software && !this.isRough ? 2 : 1) * (window.devicePixelRatio || 1), 2); }

  drawn() {
    const [side, up, back] = [0, 1, 2].map((column) => new T.Vector3().setFromMatrixColumn(this.camera.matrixWorld, column));
    this.sun.position.copy(back).addScaledVector(up, 1.1).addScaledVector(side, -0.8);
    this.fill.position.copy(back).addScaledVector(side, 1.1).addScaledVector(up, -0.2);
    this.renderer.render(this.scene, this.camera);
    this.ondrawn?.();
  }

  // Whether a point of a result is seen: no metal is before it, and no section has taken it away.
  sees(point) {
    if (this.clip.distanceToPoint(new T.Vector3(...point)) < 0) return false;
    const toEye = new T.Vector3().setFromMatrixColumn(this.camera.matrixWorld, 2).toArray();
    const before = (at) => at.some((value, axis) => Math.abs(value - point[axis]) > HAIR_MM) && at.reduce((sum, value, axis) => sum + (value - point[axis]) * toEye[axis], 0) > 0;
    return !this.bodyRays?.cast(point, toEye, (at) => before(at) && this.clip.distanceToPoint(new T.Vector3(...at)) >= 0, true);
  }

  // Where a point of the scene is in the box [px], and how near to the eye.
  placed(point) {
    const s = new T.Vector3(...point).project(this.camera);
    return [((s.x + 1) / 2) * this.box.clientWidth, ((1 - s.y) / 2) * this.box.clientHeight, -s.z];
  }

  // --- picking --------------------------------------------------------------------------------------------

  ray(clientX, clientY) {
    const frame = this.renderer.domElement.getBoundingClientRect();
    const at = new T.Vector3(((clientX - frame.left) / frame.width) * 2 - 1, 1 - ((clientY - frame.top) / frame.height) * 2, -1).unproject(this.camera);
    const way = new T.Vector3().setFromMatrixColumn(this.camera.matrixWorld, 2).negate();
    return [at.toArray(), way.toArray()];
  }

  // Which way the eye is, from the crank; right, up and towards the eye as the camera has them; how far the crank reaches from its axis, and where its webs begin and end.
  eye() { return this.axes()[2]; }
  axes() { this.camera.updateMatrixWorld(); return [0, 1, 2].map((column) => new T.Vector3().setFromMatrixColumn(this.camera.matrixWorld, column).toArray()); }
  reach() { return this.sets[this.mode] ? reached(this.corners()) : null; }
  // The diameter of the journal, crankpin or other cylinder on which a picked point lies; null elsewhere.
  roundAt({ point, part }) {
    return this.parts[part - 1]?.diameter_mm ?? roundOf(point, this.sets[this.mode].anatomy);
  }

  // What is under a place of the window: { point, part } or null; part counts from 1, 0 is none, as in a result.
  pick(clientX, clientY) {
    if (this.mode === "result" && this.bodyRays) return this.hits(this.bodyRays, clientX, clientY);
    if (!this.rays || this.mode !== "crank") return null;
    const hit = this.hits(this.rays, clientX, clientY);
    return hit && { point: hit.point, part: this.part[hit.triangle] };
  }
  hits(rays, clientX, clientY) {
    const [origin, way] = this.ray(clientX, clientY);
    const begin = origin.map((value, axis) => value - 1e4 * way[axis]);
    const hit = rays.cast(begin, way, (point) => this.clip.distanceToPoint(new T.Vector3(...point)) >= 0);
    return hit && { part: 0, ...hit };
  }

  // Where a part is on the screen: for tests and scripts that drive the page.
  whereIs(part) {
    const { p, t } = this.rays, frame = this.renderer.domElement.getBoundingClientRect();
    for (let k = 0; k < this.part.length; k++) {
      if (this.part[k] !== part) continue;
      const middle = [0, 1, 2].map((axis) => (p[3 * t[3 * k] + axis] + p[3 * t[3 * k + 1] + axis] + p[3 * t[3 * k + 2] + axis]) / 3);
      const s = new T.Vector3(...middle).project(this.camera);
      const x = frame.left + ((s.x + 1) / 2) * frame.width, y = frame.top + ((1 - s.y) / 2) * frame.height;
      if (x > frame.left && x < frame.right && y > frame.top && y < frame.bottom && this.pick(x, y)?.part === part) return [x, y];
    }
    return null;
  }
}
