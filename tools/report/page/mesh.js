// The mesh: its surface and a section, turned with the mouse or the keyboard (three.js).
"use strict";
(() => {
  const { data, make } = weft;
  if (!data.mesh) return;
  const mesh = data.mesh, [lo, hi] = mesh.box, RED = [215, 25, 28];
  const VIRIDIS = { scale: [0, 1, 2, 3, 4, 5, 6, 7].map((i) => `rgb(${weft.viridis(i / 7)})`) };
  const bytesOf = (text) => Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
  const words = (text, Type) => new Type(bytesOf(text).buffer);

  function layer(raw) {
    return { axis: raw.axis, position: raw.position, facets: raw.facets, thinned: raw.thinned, positions: words(raw.positions, Uint16Array), corners: words(raw.corners, Uint32Array),
      subdomain: words(raw.subdomain, Uint16Array), quality: bytesOf(raw.quality), length: bytesOf(raw.length), conforming: bytesOf(raw.conforming), deviation: raw.deviation && bytesOf(raw.deviation) };
  }
  const colourings = {
    plain: () => [185, 205, 224],
    subdomain: (l, f) => weft.categoryColour(l.subdomain[f]),
    quality: (l, f) => weft.viridis(l.quality[f] / 255),
    length(l, f) {
      const t = Math.max(-1, Math.min(1, ((l.length[f] / 255) * 8 - 4) / 2));
      return t < 0 ? [0, 1, 2].map((k) => Math.round(235 + t * (235 - [33, 102, 172][k]))) : [0, 1, 2].map((k) => Math.round(235 - t * (235 - [178, 24, 43][k])));
    },
    conforming: (l, f) => (l.conforming[f] ? [214, 220, 228] : RED),
    deviation: (l, f) => (l.deviation && l.deviation[f] < 255 ? weft.viridis(l.deviation[f] / 254) : colourings.plain()),
  };
  const keys = {
    plain: [], subdomain: ["a colour a subdomain"],
    quality: ["quality (mean ratio): 0", VIRIDIS, "1"],
    length: ["edge of the tet that is farthest from length 1 in the metric: ¼ or less", { scale: ["#2166ac", "#ebebeb", "#b2182b"] }, "4 or more"],
    conforming: [["#d6dce4", "conforming"], ["#d7191c", "an edge outside [1/√2, √2]"]],
    deviation: ["distance of the triangle from the CAD model: 0", VIRIDIS, weft.digits(mesh.largest_deviation ?? 0)],
  };

  function geometryOf(l, by) {
    const positions = new Float32Array(9 * l.facets), colours = new Uint8Array(9 * l.facets), size = hi.map((h, a) => h - lo[a]);
    for (let f = 0; f < l.facets; ++f) {
      const colour = colourings[by](l, f);
      for (let i = 0; i < 3; ++i) for (let a = 0; a < 3; ++a) {
        positions[9 * f + 3 * i + a] = lo[a] + (l.positions[3 * l.corners[3 * f + i] + a] / 65535) * size[a];
        colours[9 * f + 3 * i + a] = colour[a];
      }
    }
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.BufferAttribute(positions, 3));
    geometry.setAttribute("color", new THREE.BufferAttribute(colours, 3, true));
    geometry.computeVertexNormals();
    return geometry;
  }

  function supported() {
    const canvas = document.createElement("canvas");
    return Boolean(canvas.getContext("webgl") || canvas.getContext("experimental-webgl"));
  }

  function scene(canvas) {
    const layers = mesh.layers.map(layer), centre = lo.map((l, a) => (l + hi[a]) / 2), extent = Math.hypot(...hi.map((h, a) => h - lo[a]));
    const renderer = new THREE.WebGLRenderer({ canvas, antialias: true, preserveDrawingBuffer: true });
    renderer.localClippingEnabled = true;
    const world = new THREE.Scene(), camera = new THREE.PerspectiveCamera(32, 1, extent / 1000, 20 * extent);
    camera.up.set(0, 0, 1);
    const home = () => { camera.position.set(centre[0] + 1.15 * extent, centre[1] - 1.35 * extent, centre[2] + 0.85 * extent); controls.target.set(...centre); controls.update(); };
    const controls = new THREE.OrbitControls(camera, canvas);
    world.add(new THREE.AmbientLight(0xffffff, 0.62));
    const lamp = new THREE.DirectionalLight(0xffffff, 0.5);
    world.add(lamp);
    const plane = new THREE.Plane(), state = { by: "quality", axis: -1, index: 0, edges: true };
    let parts = [];

    function add(l, clipped) {
      const geometry = geometryOf(l, state.by), clippingPlanes = clipped ? [plane] : [];
      const lit = l.axis < 0 && state.by !== "conforming";
      const Material = lit ? THREE.MeshLambertMaterial : THREE.MeshBasicMaterial;
      const faces = new THREE.Mesh(geometry, new Material({ vertexColors: THREE.VertexColors, side: THREE.DoubleSide, clippingPlanes, polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1 }));
      parts.push(faces);
      if (state.edges) {
        const lines = new THREE.LineSegments(new THREE.WireframeGeometry(geometry), new THREE.LineBasicMaterial({ color: 0x1b2330, transparent: true, opacity: 0.28, clippingPlanes }));
        parts.push(lines);
      }
    }
    function rebuild() {
      for (const part of parts) { world.remove(part); part.geometry.dispose(); part.material.dispose(); }
      parts = [];
      const section = layers.filter((l) => l.axis === state.axis && l.axis >= 0)[state.index];
      if (section) {
        plane.normal.set(0, 0, 0).setComponent(state.axis, -1);
        plane.constant = section.position;
        // Of the two halves the one that is seen from behind the section stays.
        if (state.axis === 1) { plane.normal.setComponent(1, 1); plane.constant = -section.position; }
      }
      add(layers[0], Boolean(section));
      if (section) add(section, false);
      parts.forEach((p) => world.add(p));
      canvas.dataset.facets = layers[0].facets + (section ? section.facets : 0);
      render();
    }
    function render() {
      const width = canvas.clientWidth, height = canvas.clientHeight;
      if (!width) return;
      renderer.setPixelRatio(devicePixelRatio || 1);
      renderer.setSize(width, height, false);
      camera.aspect = width / height;
      camera.updateProjectionMatrix();
      renderer.setClearColor(new THREE.Color(weft.css("--card")));
      lamp.position.copy(camera.position);
      renderer.render(world, camera);
    }
    controls.addEventListener("change", render);
    weft.onTheme.push(render);
    new ResizeObserver(render).observe(canvas);
    home();
    const turn = (around, over) => {
      const spherical = new THREE.Spherical(), offset = camera.position.clone().sub(controls.target), flip = new THREE.Quaternion().setFromUnitVectors(camera.up, new THREE.Vector3(0, 1, 0));
      spherical.setFromVector3(offset.applyQuaternion(flip));
      spherical.theta += around;
      spherical.phi = Math.max(0.05, Math.min(Math.PI - 0.05, spherical.phi + over));
      camera.position.copy(controls.target).add(new THREE.Vector3().setFromSpherical(spherical).applyQuaternion(flip.inverse()));
      controls.update();
      render();
    };
    const nearer = (factor) => { camera.position.sub(controls.target).multiplyScalar(factor).add(controls.target); controls.update(); render(); };
    return { state, layers, rebuild, render, home, turn, nearer };
  }

  let view = null;
  function keyOf(by) {
    return make("div", { class: "legend" }, keys[by].map((k) => (typeof k === "string" ? make("span", {}, k) : k.scale ? make("span", {}, make("i", { class: "scale", style: `background:linear-gradient(to right,${k.scale})` })) : make("span", {}, make("i", { style: `background:${k[0]}` }), k[1]))));
  }
  function build() {
    if (!supported()) return [weft.card("Mesh", weft.empty("This browser has no WebGL. `weft view` draws the mesh into a file."))];
    const canvas = make("canvas", { id: "mesh-canvas", tabindex: 0, role: "img", "aria-label": "The mesh. Arrow keys turn it, plus and minus zoom, Home resets." });
    const key = make("div"), note = make("p", { class: "note" }), place = make("span", { class: "note" });
    const slider = make("input", { type: "range", id: "clip-position", min: 0, max: 0, value: 0, disabled: true, "aria-label": "Position of the section" });
    const sections = (axis) => view.layers.filter((l) => l.axis === axis && axis >= 0);
    function update() {
      key.replaceChildren(keyOf(view.state.by));
      const list = sections(view.state.axis);
      slider.max = Math.max(0, list.length - 1);
      slider.value = view.state.index;
      slider.disabled = list.length === 0;
      place.textContent = list.length ? `${"xyz"[view.state.axis]} = ${weft.digits(list[view.state.index].position)}` : "";
      const thinned = view.layers[0].thinned || list.some((l) => l.thinned);
      note.textContent = `${weft.count(view.layers[0].facets)} facets of the surface.` + (thinned ? " The mesh has more than a page should hold: vertices near each other are drawn as one, with the worst value." : "");
      view.rebuild();
    }
    const tool = make("div", { class: "tool" }, "Colour:",
      weft.choice("colour", [["quality", "Quality"], ["length", "Edge length"], ["conforming", "Not conforming"], ["subdomain", "Subdomains"], ...(mesh.largest_deviation == null ? [] : [["deviation", "Deviation"]]), ["plain", "Plain"]], (by) => { view.state.by = by; update(); }),
      "Cut:", weft.choice("clip", [["-1", "none"], ["0", "x"], ["1", "y"], ["2", "z"]], (axis) => { view.state.axis = Number(axis); view.state.index = Math.floor(sections(view.state.axis).length / 2); update(); }),
      slider, place, make("label", {}, make("input", { type: "checkbox", checked: true, onchange: (e) => { view.state.edges = e.target.checked; update(); } }), "edges"), make("button", { type: "button", onclick: () => { view.home(); view.render(); } }, "Reset"));
    slider.addEventListener("input", () => { view.state.index = Number(slider.value); update(); });
    canvas.addEventListener("keydown", (event) => {
      const acts = { ArrowLeft: () => view.turn(-0.1, 0), ArrowRight: () => view.turn(0.1, 0), ArrowUp: () => view.turn(0, -0.1), ArrowDown: () => view.turn(0, 0.1), "+": () => view.nearer(0.85), "=": () => view.nearer(0.85), "-": () => view.nearer(1 / 0.85), Home: () => { view.home(); view.render(); } };
      if (!acts[event.key]) return;
      event.preventDefault();
      acts[event.key]();
    });
    const card = weft.card("Mesh", tool, canvas, key, note);
    requestAnimationFrame(() => { view = scene(canvas); update(); });
    return [card];
  }
  weft.views.push({ id: "mesh", title: "Mesh", build, onshow: () => view && view.render() });
})();
