// The crank in 3D: buffers from the server, drawn with three.js; the scene is the rotor frame in mm.
const T = window.THREE;
const GREY = 0x9aa7b5, BLUE = 0x2a7de1;

export class View {
  constructor(box, canvas, note) {
    this.box = box; this.note = note; this.mark = null;
    try {
      this.renderer = new T.WebGLRenderer({ canvas, antialias: true, alpha: true });
    } catch {
      note.textContent = "This browser shows no 3D; everything else works";
      return;
    }
    this.scene = new T.Scene();
    this.scene.add(new T.AmbientLight(0xffffff, 1.3));
    const sun = new T.DirectionalLight(0xffffff, 2.2);
    sun.position.set(1, 2, 3);
    this.scene.add(sun);
    this.camera = new T.OrthographicCamera(-1, 1, 1, -1, -1e4, 1e4);
    this.controls = new T.OrbitControls(this.camera, canvas);
    this.controls.addEventListener("change", () => this.draw());
    new ResizeObserver(() => this.resize()).observe(box);
    box.addEventListener("keydown", (event) => this.key(event));
  }

  // Show a crank: Uint32 corner and triangle counts, Float32 corners, Uint32 triangles.
  show(buffer) {
    const [corners, triangles] = new Uint32Array(buffer, 0, 2);
    this.box.dataset.triangles = String(triangles);
    if (!this.renderer) { this.box.dataset.state = "ready"; return; }
    const geometry = new T.BufferGeometry();
    geometry.setAttribute("position", new T.BufferAttribute(new Float32Array(buffer, 8, 3 * corners), 3));
    geometry.setIndex(new T.BufferAttribute(new Uint32Array(buffer, 8 + 12 * corners, 3 * triangles), 1));
    geometry.computeBoundingSphere();
    if (this.mesh) { this.scene.remove(this.mesh); this.mesh.geometry.dispose(); }
    this.mesh = new T.Mesh(geometry, new T.MeshStandardMaterial({ color: GREY, flatShading: true, metalness: 0.2, roughness: 0.7, side: T.DoubleSide }));
    this.scene.add(this.mesh);
    const { center, radius } = geometry.boundingSphere;
    this.radius = radius;
    this.controls.target.copy(center);
    this.camera.up.set(1, 0, 0);
    this.camera.position.copy(center).add(new T.Vector3(0.9 * radius, 1.6 * radius, 1.9 * radius));
    this.note.textContent = `${triangles.toLocaleString("en")} triangles; drag to turn, wheel to zoom`;
    this.resize();
    this.box.dataset.state = "ready";
  }

  // Mark a part: a ring about its axis at a place, in the rotor frame.
  point(centre, radius) {
    if (!this.renderer) return;
    if (this.mark) this.scene.remove(this.mark);
    this.mark = null;
    if (centre) {
      const ring = new T.RingGeometry(radius, radius + 0.04 * this.radius, 64);
      this.mark = new T.Mesh(ring, new T.MeshBasicMaterial({ color: BLUE, side: T.DoubleSide, depthTest: false, transparent: true, opacity: 0.85 }));
      this.mark.position.set(...centre);
      this.mark.renderOrder = 2;
      this.scene.add(this.mark);
    }
    this.draw();
  }

  key(event) {
    const turn = { ArrowLeft: [-0.12, 0], ArrowRight: [0.12, 0], ArrowUp: [0, -0.12], ArrowDown: [0, 0.12] }[event.key];
    if (!turn || !this.mesh) return;
    const away = this.camera.position.clone().sub(this.controls.target);
    const side = new T.Vector3().copy(this.camera.up).cross(away).normalize();
    away.applyAxisAngle(this.camera.up, turn[0]).applyAxisAngle(side, turn[1]);
    this.camera.position.copy(this.controls.target).add(away);
    this.controls.update();
    this.draw();
    event.preventDefault();
  }

  resize() {
    const { clientWidth: width, clientHeight: height } = this.box;
    if (!this.renderer || !width || !height) return;
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio || 1, 2));
    this.renderer.setSize(width, height, false);
    const half = 1.15 * (this.radius || 1), aspect = width / height;
    Object.assign(this.camera, { left: -half * Math.max(1, aspect), right: half * Math.max(1, aspect), top: half * Math.max(1, 1 / aspect), bottom: -half * Math.max(1, 1 / aspect) });
    this.camera.updateProjectionMatrix();
    this.controls.update();
    this.draw();
  }

  draw() { this.renderer.render(this.scene, this.camera); }
}
