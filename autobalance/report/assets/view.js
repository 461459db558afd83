// The crank on the page: turn, zoom, section, pick. Draws what Python put into #view-data and #view-mesh;
// the scene's x is the crank axis (rotor z), its y points to crankpin 1 (rotor x).
"use strict";
(() => {
  const stage = document.getElementById("stage");
  const source = document.getElementById("view-data");
  if (!stage || !source) return;
  const data = JSON.parse(source.textContent);
  const rows = [...document.querySelectorAll("tr[data-part]")];
  const said = document.getElementById("said");
  const css = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

  let show3d = { choose() {} };
  let chosen = null;

  function choose(part, from) {
    chosen = part;
    for (const row of rows) {
      const on = row.dataset.part === String(part);
      row.setAttribute("aria-selected", on ? "true" : "false");
      if (on && from !== "row") row.scrollIntoView({ block: "nearest" });
    }
    const item = data.corrections.find((c) => c.number === part);
    said.textContent = item ? item.said : "Nothing selected";
    document.documentElement.dataset.chosen = part === null ? "" : String(part);
    show3d.choose(part, from);
  }
  for (const [place, row] of rows.entries()) {
    const part = Number(row.dataset.part);
    row.addEventListener("click", () => choose(chosen === part ? null : part, "row"));
    row.addEventListener("keydown", (event) => {
      const step = { ArrowDown: 1, ArrowUp: -1 }[event.key];
      if (event.key === "Enter" || event.key === " ") choose(chosen === part ? null : part, "row");
      else if (event.key === "Escape") choose(null, "row");
      else if (step && rows[place + step]) rows[place + step].focus();
      else return;
      event.preventDefault();
    });
  }

  try {
    show3d = build();
    stage.classList.add("live");
  } catch (error) {
    document.getElementById("no3d").hidden = false; // no WebGL: the still picture stays
  }

  function bytes() {
    const text = atob(document.getElementById("view-mesh").textContent.trim());
    const raw = new Uint8Array(text.length);
    for (let i = 0; i < text.length; i++) raw[i] = text.charCodeAt(i);
    return raw.buffer;
  }

  function build() {
    const buffer = bytes();
    const canvas = document.getElementById("canvas");
    const renderer = new THREE.WebGLRenderer({ canvas, antialias: true, alpha: true });
    renderer.setPixelRatio(Math.min(window.devicePixelRatio || 1, 2));
    renderer.localClippingEnabled = true;
    const scene = new THREE.Scene();
    const rotor = new THREE.Group();
    scene.add(rotor);
    const reach = data.radius_mm;
    const length = data.z_mm[1] - data.z_mm[0];
    const middle = new THREE.Vector3((data.z_mm[0] + data.z_mm[1]) / 2, 0, 0);
    const size = Math.hypot(length / 2, reach) * 1.06;
    const camera = new THREE.OrthographicCamera(-1, 1, 1, -1, -20 * size, 20 * size);
    const controls = new THREE.OrbitControls(camera, canvas);
    controls.target.copy(middle);
    controls.enableDamping = false;
    controls.minZoom = 0.4;
    controls.maxZoom = 30;
    const cutPlane = new THREE.Plane(new THREE.Vector3(-1, 0, 0), 1e9);

    const key = new THREE.DirectionalLight(0xffffff, 2.0);
    const fill = new THREE.DirectionalLight(0xffffff, 1.0);
    scene.add(new THREE.AmbientLight(0xffffff, 0.85), key, fill, key.target, fill.target);

    const metal = new THREE.MeshStandardMaterial({ flatShading: true, roughness: 0.62, metalness: 0.05, clippingPlanes: [cutPlane], polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1 });
    const caps = new THREE.MeshBasicMaterial({ side: THREE.BackSide, clippingPlanes: [cutPlane], polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1 });
    const lines = new THREE.LineBasicMaterial({ clippingPlanes: [cutPlane] });

    const low = data.low_mm;
    const step = data.step_mm;
    function geometry(part) {
      const packed = new Uint16Array(buffer, part.vertices[0], part.vertices[1] * 3);
      const place = new Float32Array(packed.length);
      for (let i = 0; i < packed.length; i += 3) {
        const x = low[0] + step * packed[i], y = low[1] + step * packed[i + 1], z = low[2] + step * packed[i + 2];
        place[i] = z; place[i + 1] = x; place[i + 2] = y;
      }
      const shape = new THREE.BufferGeometry();
      shape.setAttribute("position", new THREE.BufferAttribute(place, 3));
      shape.setIndex(new THREE.BufferAttribute(new Uint32Array(buffer, part.triangles[0], part.triangles[1] * 3), 1));
      return shape;
    }
    function creases(shape, degrees) {
      const p = shape.attributes.position.array, t = shape.index.array, n = p.length / 3;
      const normal = new Float32Array(t.length);
      const sides = new Map();
      const limit = Math.cos((degrees * Math.PI) / 180);
      const found = [];
      for (let k = 0; k < t.length; k += 3) {
        const a = 3 * t[k], b = 3 * t[k + 1], c = 3 * t[k + 2];
        const ux = p[b] - p[a], uy = p[b + 1] - p[a + 1], uz = p[b + 2] - p[a + 2];
        const vx = p[c] - p[a], vy = p[c + 1] - p[a + 1], vz = p[c + 2] - p[a + 2];
        const x = uy * vz - uz * vy, y = uz * vx - ux * vz, z = ux * vy - uy * vx, s = Math.hypot(x, y, z) || 1;
        normal[k] = x / s; normal[k + 1] = y / s; normal[k + 2] = z / s;
        for (let e = 0; e < 3; e++) {
          const i = t[k + e], j = t[k + ((e + 1) % 3)];
          const name = i < j ? i * n + j : j * n + i;
          const other = sides.get(name);
          if (other === undefined) sides.set(name, k);
          else if (normal[k] * normal[other] + normal[k + 1] * normal[other + 1] + normal[k + 2] * normal[other + 2] < limit)
            found.push(p[3 * i], p[3 * i + 1], p[3 * i + 2], p[3 * j], p[3 * j + 1], p[3 * j + 2]);
        }
      }
      const shapeOfLines = new THREE.BufferGeometry();
      shapeOfLines.setAttribute("position", new THREE.BufferAttribute(new Float32Array(found), 3));
      return new THREE.LineSegments(shapeOfLines, lines);
    }

    const body = geometry(data.body);
    rotor.add(new THREE.Mesh(body, metal), new THREE.Mesh(body, caps), creases(body, 28));
    const skins = new THREE.Group(), floors = new THREE.Group();
    rotor.add(skins, floors);
    const pickable = [];
    for (const piece of data.pieces) {
      const skin = new THREE.MeshStandardMaterial({ flatShading: true, roughness: 0.7, clippingPlanes: [cutPlane], side: THREE.DoubleSide });
      const floor = new THREE.MeshStandardMaterial({ flatShading: true, roughness: 0.7, clippingPlanes: [cutPlane], polygonOffset: true, polygonOffsetFactor: -1, polygonOffsetUnits: -2 });
      const solid = new THREE.Mesh(geometry(piece.skin), skin), bottom = new THREE.Mesh(geometry(piece.floor), floor);
      const edges = creases(solid.geometry, 28);
      solid.userData.part = bottom.userData.part = piece.number;
      skins.add(solid, edges);
      floors.add(bottom);
      pickable.push({ piece, solid, bottom });
    }

    // --- axis, planes, unbalance vectors ------------------------------------------------------------------
    const ink = { axis: new THREE.LineDashedMaterial({ dashSize: length / 22, gapSize: length / 70 }), judge: new THREE.LineBasicMaterial(), cut: new THREE.LineDashedMaterial({ dashSize: reach / 14, gapSize: reach / 18 }) };
    const planes = new THREE.Group(), vectors = new THREE.Group();
    scene.add(planes, vectors);
    function poly(points, material, parent) {
      const shape = new THREE.BufferGeometry();
      const pairs = [];
      for (let i = 0; i + 1 < points.length; i++) pairs.push(...points[i], ...points[i + 1]);
      shape.setAttribute("position", new THREE.BufferAttribute(new Float32Array(pairs), 3));
      const line = new THREE.LineSegments(shape, material);
      if (material.isLineDashedMaterial) line.computeLineDistances();
      parent.add(line);
    }
    poly([[data.z_mm[0] - 0.14 * length, 0, 0], [data.z_mm[1] + 0.14 * length, 0, 0]], ink.axis, planes);
    const ring = (z, r, material) => poly(Array.from({ length: 97 }, (_, k) => [z, r * Math.cos((k * Math.PI) / 48), r * Math.sin((k * Math.PI) / 48)]), material, planes);
    const tags = [];
    const ringRadius = reach * 1.1;
    for (const plane of data.tolerance_planes) {
      ring(plane.z_mm, ringRadius, ink.judge);
      tags.push(tag("plane", null, `${plane.name}`, [plane.z_mm, -ringRadius, 0], planes));
    }
    for (const z of data.correction_planes_mm) ring(z, reach * 1.04, ink.cut);
    const largest = Math.max(...data.vectors.map((v) => Math.hypot(...v.vector)), 1e-12);
    const drawn = [];
    for (const v of data.vectors) {
      const long = (Math.hypot(...v.vector) / largest) * reach * 1.25;
      if (long < reach * 0.02) continue;
      const way = new THREE.Vector3(0, v.vector[0], v.vector[1]).normalize();
      const arrow = new THREE.ArrowHelper(way, new THREE.Vector3(v.z_mm, 0, 0), long, 0xffffff, Math.min(reach * 0.16, long * 0.5), Math.min(reach * 0.08, long * 0.25));
      for (const one of [arrow.line, arrow.cone]) { one.material.depthTest = false; one.renderOrder = 5; }
      vectors.add(arrow);
      drawn.push({ arrow, when: v.when });
      tags.push(tag(v.when, null, v.text, way.clone().multiplyScalar(long * 1.06).setX(v.z_mm).toArray(), vectors));
    }
    for (const item of data.corrections) tags.push(tag("part", item, item.depth_text, [item.label_mm[2], item.label_mm[0], item.label_mm[1]], null));

    function tag(kind, item, text, place, group) {
      const node = document.createElement("div");
      node.className = `tag ${kind}`;
      if (item) { const b = document.createElement("b"); b.textContent = item.number; node.append(b); }
      const span = document.createElement("span");
      span.textContent = text;
      node.append(span);
      document.getElementById("tags").append(node);
      return { node, item, place: new THREE.Vector3(...place), group };
    }

    // --- colours -----------------------------------------------------------------------------------------
    function paint() {
      const dark = matchMedia("(prefers-color-scheme: dark)").matches;
      metal.color.set(dark ? "#8f979f" : "#b3b9bf");
      caps.color.set(dark ? "#4a5560" : "#7d8893");
      lines.color.set(dark ? "#0d0f11" : "#4a5057");
      ink.axis.color.set(css("--bad"));
      ink.judge.color.set(css("--good"));
      ink.cut.color.set(css("--soft"));
      const [a, b] = [new THREE.Color(css("--cut-low")), new THREE.Color(css("--cut-high"))];
      for (const { piece, solid, bottom } of pickable) {
        const on = piece.number === chosen;
        for (const one of [solid, bottom]) {
          one.material.color.copy(a).lerp(b, piece.shade);
          one.material.emissive.set(on ? css("--accent") : "#000000");
          one.material.emissiveIntensity = on ? 0.75 : 0;
        }
      }
      for (const { arrow, when } of drawn) arrow.setColor(new THREE.Color(css(when === "before" ? "--before" : "--accent")));
    }

    // --- camera, labels, drawing -------------------------------------------------------------------------
    const views = { oblique: [data.eye[2], data.eye[0], data.eye[1]], side: [0, 0, 1], end: [1, 0, 0] };
    function look(name) {
      const [x, y, z] = views[name];
      camera.position.copy(new THREE.Vector3(x, y, z).normalize().multiplyScalar(4 * size)).add(middle);
      camera.zoom = 1;
      controls.update();
      resize();
    }
    function resize() {
      const w = stage.clientWidth, h = stage.clientHeight;
      renderer.setSize(w, h, false);
      const tall = Math.max(size * 0.86, (size * 0.98 * h) / w);
      camera.top = tall; camera.bottom = -tall;
      camera.right = (tall * w) / h; camera.left = -camera.right;
      camera.updateProjectionMatrix();
      draw();
    }
    // turn the view to a cut; the zoom stays as it is
    function turnTo(towards) {
      camera.position.set(towards[2], towards[0], towards[1]).normalize().multiplyScalar(4 * size).add(middle);
      camera.updateProjectionMatrix();
      controls.update();
      camera.updateMatrixWorld();
    }
    // labels give way: the chosen one first, then those in front; one that would lie over another is left out
    const sizes = new Map();
    function sizeOf(node) {
      const key = `${node.textContent}|${node.lastChild.hidden}`;
      if (!sizes.has(key)) sizes.set(key, [node.offsetWidth, node.offsetHeight]);
      return sizes.get(key);
    }
    function giveWay(shown) {
      const frame = stage.getBoundingClientRect();
      const taken = [...stage.querySelectorAll(".key:not([hidden]), .hint")].map((node) => {
        const r = node.getBoundingClientRect();
        return [r.left - frame.left, r.top - frame.top, r.right - frame.left, r.bottom - frame.top];
      });
      shown.sort((a, b) => (b.rank - a.rank) || (a.depth - b.depth));
      for (const { node, x, y } of shown) {
        const [w, h] = sizeOf(node);
        const box = [x - 10, y - h / 2, x - 10 + w, y + h / 2];
        const covered = taken.some((t) => box[0] < t[2] && t[0] < box[2] && box[1] < t[3] && t[1] < box[3]);
        node.style.visibility = covered ? "hidden" : "visible";
        if (!covered) taken.push(box);
      }
    }
    const ray = new THREE.Raycaster();
    let waiting = false;
    function draw() {
      if (waiting) return;
      waiting = true;
      requestAnimationFrame(() => {
        waiting = false;
        const side = new THREE.Vector3().setFromMatrixColumn(camera.matrixWorld, 0);
        const up = new THREE.Vector3().setFromMatrixColumn(camera.matrixWorld, 1);
        const back = new THREE.Vector3().setFromMatrixColumn(camera.matrixWorld, 2);
        key.position.copy(back).addScaledVector(up, 1.1).addScaledVector(side, -0.8);
        fill.position.copy(back).addScaledVector(side, 1.1).addScaledVector(up, -0.2);
        renderer.render(scene, camera);
        const w = stage.clientWidth, h = stage.clientHeight, p = new THREE.Vector3();
        const shown = [];
        for (const { node, place, group, item } of tags) {
          p.copy(place).project(camera);
          const x = ((p.x + 1) / 2) * w, y = ((1 - p.y) / 2) * h;
          node.style.transform = `translate(${x}px, ${y}px) translate(-10px, -50%)`;
          node.hidden = (group && !group.visible) || (item && !partsShown());
          const own = item && item.number === chosen;
          if (item) {
            node.classList.toggle("chosen", own);
            node.lastChild.hidden = data.corrections.length > 3 && !own;
          }
          if (!node.hidden) shown.push({ node, x, y, depth: p.z, rank: own ? 2 : item ? 0 : 1 });
        }
        giveWay(shown);
      });
    }
    const box = (name) => document.getElementById(name);
    const partsShown = () => box("show-labels").checked;
    function pick(event) {
      const frame = canvas.getBoundingClientRect();
      const at = new THREE.Vector2(((event.clientX - frame.left) / frame.width) * 2 - 1, 1 - ((event.clientY - frame.top) / frame.height) * 2);
      ray.setFromCamera(at, camera);
      const targets = pickable.map((one) => (skins.visible ? one.solid : one.bottom));
      const kept = (hit) => cutPlane.distanceToPoint(hit.point) >= 0;
      const hit = ray.intersectObjects(targets, false).find(kept);
      const wall = hit && ray.intersectObject(rotor.children[0], false).find(kept);
      const hidden = wall && wall.distance < hit.distance - 1e-3 * size;
      choose(hit && !hidden ? hit.object.userData.part : null, "part");
    }
    let down = null;
    canvas.addEventListener("pointerdown", (event) => { down = [event.clientX, event.clientY]; });
    canvas.addEventListener("pointerup", (event) => {
      if (down && Math.hypot(event.clientX - down[0], event.clientY - down[1]) < 4) pick(event);
      down = null;
    });
    canvas.addEventListener("keydown", (event) => {
      const turn = { ArrowLeft: [-0.12, 0], ArrowRight: [0.12, 0], ArrowUp: [0, -0.12], ArrowDown: [0, 0.12] }[event.key];
      if (turn) {
        const about = new THREE.Spherical().setFromVector3(camera.position.clone().sub(middle));
        about.theta += turn[0];
        about.phi = Math.min(Math.PI - 0.01, Math.max(0.01, about.phi + turn[1]));
        camera.position.setFromSpherical(about).add(middle);
      } else if (event.key === "+" || event.key === "=") camera.zoom = Math.min(30, camera.zoom * 1.15);
      else if (event.key === "-") camera.zoom = Math.max(0.4, camera.zoom / 1.15);
      else if (event.key === "0" || event.key === "Home") { look("oblique"); event.preventDefault(); return; }
      else if (event.key === "Escape") { choose(null, "part"); return; }
      else return;
      event.preventDefault();
      camera.updateProjectionMatrix();
      controls.update();
      draw();
    });
    controls.addEventListener("change", draw);

    function section() {
      const axis = box("section").value, slider = box("section-at");
      slider.disabled = axis === "none";
      const share = Number(slider.value) / 100;
      const ways = { z: [-1, 0, 0], x: [0, -1, 0], y: [0, 0, -1] };
      const range = axis === "z" ? data.z_mm : [-reach, reach];
      const place = range[0] + share * (range[1] - range[0]);
      cutPlane.set(new THREE.Vector3(...(ways[axis] || ways.z)), axis === "none" ? 1e9 : place);
      const digits = data.length === "mm" ? 1 : 3;
      const said = `${axis} = ${(place / data.mm_per_length).toFixed(digits)} ${data.length}`;
      slider.setAttribute("aria-valuetext", axis === "none" ? "no section" : said);
      box("section-text").textContent = axis === "none" ? "" : said;
      draw();
    }
    function shown() {
      skins.visible = box("metal-on").checked;
      floors.visible = !skins.visible;
      planes.visible = box("show-planes").checked;
      vectors.visible = box("show-vectors").checked;
      draw();
    }
    for (const name of ["metal-on", "metal-off", "show-planes", "show-vectors", "show-labels"]) box(name).addEventListener("change", shown);
    box("section").addEventListener("change", section);
    box("section-at").addEventListener("input", section);
    for (const button of document.querySelectorAll("button[data-view]")) button.addEventListener("click", () => look(button.dataset.view));
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => { paint(); draw(); });
    new ResizeObserver(resize).observe(stage);
    paint(); shown(); section(); look("oblique");
    // the place on the screen of a triangle of a part that nothing hides; null where all of it is hidden
    function whereIs(part) {
      const one = pickable.find((p) => p.piece.number === part);
      if (!one) return null;
      const mesh = skins.visible ? one.solid : one.bottom;
      const p = mesh.geometry.attributes.position.array, t = mesh.geometry.index.array;
      const frame = canvas.getBoundingClientRect();
      const places = [];
      for (let k = 0; k < t.length; k += 3) {
        const [a, b, c] = [0, 1, 2].map((e) => new THREE.Vector3().fromArray(p, 3 * t[k + e]).project(camera));
        const area = Math.abs((b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x));
        places.push([area, a.add(b).add(c).divideScalar(3)]);
      }
      places.sort((one, other) => other[0] - one[0]);
      for (const [, s] of places.slice(0, 200)) {
        ray.setFromCamera(new THREE.Vector2(s.x, s.y), camera);
        const all = ray.intersectObjects([rotor.children[0], ...pickable.map((q) => (skins.visible ? q.solid : q.bottom))], false);
        if (all.length && all.find((h) => h.distance < all[0].distance + 1e-3 * size && h.object === mesh)) return [frame.left + ((s.x + 1) / 2) * frame.width, frame.top + ((1 - s.y) / 2) * frame.height];
      }
      return null;
    }
    // where each part is on the screen: for tests and for scripts that drive the page
    window.autobalance = {
      whereIs,
      faces(part) {
        const item = data.corrections.find((c) => c.number === part);
        const way = new THREE.Vector3(item.towards[2], item.towards[0], item.towards[1]).normalize();
        return camera.position.clone().sub(middle).normalize().dot(way) > 0.999;
      },
      isLit: (part) => pickable.filter((p) => p.piece.number === part).every((p) => p.solid.material.emissiveIntensity > 0),
    };
    return {
      choose(part, from) {
        const item = data.corrections.find((c) => c.number === part);
        if (item && from === "row") turnTo(item.towards);
        paint();
        draw();
      },
    };
  }
})();
