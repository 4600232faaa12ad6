// Every run of a node, in the row of the worker that ran it; of many ranks some have rows, and runs of the others none. Few are drawn one by one; many are added up by pixel.
"use strict";
(() => {
  const { data, make } = weft;
  if (!data.graph || !data.timeline) return;
  const runs = data.graph.runs, uses = data.graph.uses, nodes = data.graph.graph.nodes, instances = data.graph.instances;
  const count = runs.node.length, lanes = data.timeline.lanes, laneOf = data.timeline.of_run;
  const hasLane = (r) => laneOf[r] !== null;
  const ranksOf = (list) => new Set(list).size, ranks = ranksOf(runs.rank), ranksShown = ranksOf(lanes.map((lane) => lane.rank));
  const begin = Float64Array.from(runs.begin_ns), end = begin.map((t, i) => t + runs.duration_ns[i]);
  const operation = Uint8Array.from(runs.node, (n) => data.operation_of_node[n]);
  const wall = end.reduce((a, b) => Math.max(a, b), 1);
  const critical = new Uint8Array(count);
  for (const r of data.graph.critical_path.runs) critical[r] = 1;
  const criticalUses = new Set(data.graph.critical_path.uses.filter((u) => u !== null));

  /** The runs of each lane, ascending. */
  const ofLane = lanes.map(() => []);
  for (let r = 0; r < count; ++r) if (hasLane(r)) ofLane[laneOf[r]].push(r);
  for (const list of ofLane) list.sort((a, b) => begin[a] - begin[b]);

  weft.runs = {
    /** Uses that end at a run: they are in the order of their targets. */
    into(r) {
      const list = [];
      let lo = 0, hi = uses.to.length;
      while (lo < hi) { const m = (lo + hi) >> 1; if (uses.to[m] < r) lo = m + 1; else hi = m; }
      for (; lo < uses.to.length && uses.to[lo] === r; ++lo) list.push(lo);
      return list;
    },
    from: null,
    outOf(r) {
      if (!this.from) {
        this.from = new Map();
        uses.from.forEach((f, u) => { if (!this.from.has(f)) this.from.set(f, []); this.from.get(f).push(u); });
      }
      return this.from.get(r) || [];
    },
    title: (r) => `${nodes[runs.node[r]].name}, subdomain ${instances[runs.instance[r]].number}, round ${runs.round[r]}`,
  };

  let view = { t0: 0, t1: wall, y: 0, row: 0 };
  let selected = -1, hidden = new Set(), onlyCritical = false, canvas, details, status, axisHeight = 26, labelWidth = 118;
  const frame = () => canvas.getBoundingClientRect();
  const plotWidth = () => canvas.clientWidth - labelWidth;
  const plotHeight = () => canvas.clientHeight - axisHeight;
  const fitRow = () => Math.max(2, Math.min(44, plotHeight() / lanes.length));
  const x = (t) => labelWidth + ((t - view.t0) / (view.t1 - view.t0)) * plotWidth();
  const time = (px) => view.t0 + ((px - labelWidth) / plotWidth()) * (view.t1 - view.t0);
  const rowY = (lane) => axisHeight + lane * view.row - view.y;
  const shows = (r) => !hidden.has(operation[r]) && (!onlyCritical || critical[r]);

  function clamp() {
    const width = Math.min(Math.max(view.t1 - view.t0, 200), wall * 1.02);
    view.t0 = Math.max(-0.01 * wall, Math.min(view.t0, wall * 1.01 - width));
    view.t1 = view.t0 + width;
    view.row = Math.max(2, Math.min(60, view.row));
    view.y = Math.max(0, Math.min(view.y, lanes.length * view.row - plotHeight()));
  }

  /** The first run of a lane that ends after a time. */
  function firstAfter(list, t) {
    let lo = 0, hi = list.length;
    while (lo < hi) { const m = (lo + hi) >> 1; if (end[list[m]] < t) lo = m + 1; else hi = m; }
    return lo;
  }
  function visibleLanes() {
    const first = Math.max(0, Math.floor(view.y / view.row));
    return [first, Math.min(lanes.length, Math.ceil((view.y + plotHeight()) / view.row))];
  }
  function* visibleRuns(lane) {
    const list = ofLane[lane];
    for (let i = firstAfter(list, view.t0); i < list.length && begin[list[i]] <= view.t1; ++i) if (shows(list[i])) yield list[i];
  }

  // --- Drawing

  function drawOneByOne(c, first, last) {
    const gap = view.row > 8 ? 2 : 0;
    for (let lane = first; lane < last; ++lane) for (const r of visibleRuns(lane)) {
      const left = Math.max(labelWidth, x(begin[r])), right = Math.min(canvas.clientWidth, x(end[r]));
      c.fillStyle = weft.operationColour(operation[r]);
      c.fillRect(left, rowY(lane) + gap / 2, Math.max(0.6, right - left), view.row - gap);
      if (right - left > 70 && view.row >= 14) {
        c.fillStyle = "#fff";
        c.fillText(`${instances[runs.instance[r]].number} · ${nodes[runs.node[r]].name}`, left + 4, rowY(lane) + view.row / 2 + 4, right - left - 8);
      }
    }
  }

  /** For each pixel the operation that took most of it. */
  function drawSums(c, first, last, scale) {
    const width = Math.floor(plotWidth() * scale), height = Math.floor(plotHeight() * scale);
    const image = c.createImageData(width, height), pixels = new Uint32Array(image.data.buffer);
    const colours = data.operations.map((_, o) => {
      const [r, g, b] = weft.operationColour(o).match(/\w\w/g).map((h) => parseInt(h, 16));
      return [r, g, b];
    });
    const ground = weft.css("--card").match(/\w\w/g).map((h) => parseInt(h, 16));
    const perPixel = (view.t1 - view.t0) / width, most = new Float64Array(width), which = new Uint8Array(width), sum = new Float64Array(width);
    for (let lane = first; lane < last; ++lane) {
      most.fill(0); sum.fill(0);
      for (const r of visibleRuns(lane)) {
        const from = Math.max(0, (begin[r] - view.t0) / perPixel), to = Math.min(width, (end[r] - view.t0) / perPixel);
        for (let p = Math.floor(from); p < to && p < width; ++p) {
          const part = Math.min(to, p + 1) - Math.max(from, p);
          sum[p] += part;
          if (part > most[p]) { most[p] = part; which[p] = operation[r]; }
        }
      }
      const top = Math.max(0, Math.round((lane * view.row - view.y) * scale)), bottom = Math.min(height, Math.round(((lane + 1) * view.row - view.y) * scale - (view.row > 5 ? 1 : 0)));
      for (let p = 0; p < width; ++p) {
        if (sum[p] === 0) continue;
        const share = Math.min(1, 0.25 + 0.75 * sum[p]), colour = colours[which[p]];
        const [r, g, b] = colour.map((v, k) => Math.round(share * v + (1 - share) * ground[k]));
        const word = 0xff000000 | (b << 16) | (g << 8) | r;
        for (let y = top; y < bottom; ++y) pixels[y * width + p] = word;
      }
    }
    c.putImageData(image, Math.round(labelWidth * scale), Math.round(axisHeight * scale));
  }

  function drawArrow(c, u, colour, width) {
    const a = uses.from[u], b = uses.to[u];
    if (!hasLane(a) || !hasLane(b)) return;
    const x0 = x(uses.time_ns[u]), y0 = rowY(laneOf[a]) + view.row / 2, x1 = x(begin[b]), y1 = rowY(laneOf[b]) + view.row / 2;
    c.strokeStyle = colour;
    c.lineWidth = width;
    c.beginPath();
    c.moveTo(x0, y0);
    const bend = Math.max(20, Math.abs(x1 - x0) / 2);
    c.bezierCurveTo(x0 + bend, y0, x1 - bend, y1, x1, y1);
    c.stroke();
    c.beginPath();
    c.arc(x1, y1, 3, 0, 7);
    c.fillStyle = colour;
    c.fill();
  }
  function outline(c, r, colour, width) {
    if (!hasLane(r)) return;
    c.strokeStyle = colour;
    c.lineWidth = width;
    c.strokeRect(x(begin[r]), rowY(laneOf[r]) + 0.5, Math.max(2, x(end[r]) - x(begin[r])), view.row - 1);
  }

  function drawAxis(c) {
    c.fillStyle = weft.css("--card");
    c.fillRect(0, 0, canvas.clientWidth, axisHeight);
    c.fillRect(0, 0, labelWidth, canvas.clientHeight);
    c.fillStyle = weft.css("--soft");
    c.strokeStyle = weft.css("--line");
    c.lineWidth = 1;
    const width = (view.t1 - view.t0) * 1e-9, rough = (width * 110) / plotWidth(), power = 10 ** Math.floor(Math.log10(rough));
    const step = [1, 2, 5, 10].find((s) => s * power >= rough) * power;
    for (let k = Math.ceil((view.t0 * 1e-9) / step); k * step <= view.t1 * 1e-9; ++k) {
      const at = x(k * step * 1e9);
      if (at < labelWidth) continue;
      c.fillText(k === 0 ? "0 s" : weft.seconds(Number((k * step).toPrecision(12))), at + 3, 16);
      c.beginPath();
      c.moveTo(at, 4);
      c.lineTo(at, axisHeight);
      c.stroke();
    }
    const [first, last] = visibleLanes();
    let previous = -1, lastY = -99;
    for (let lane = first; lane < last; ++lane) {
      const y = rowY(lane) + view.row / 2 + 4;
      const newRank = lanes[lane].rank !== previous;
      previous = lanes[lane].rank;
      if (y < axisHeight + 8 || y - lastY < 13) continue;
      if (view.row >= 13) c.fillText(newRank ? `rank ${lanes[lane].rank}, ${lanes[lane].name}` : lanes[lane].name, newRank ? 6 : 6 + c.measureText(`rank ${lanes[lane].rank}, `).width, y, labelWidth - 10);
      else if (newRank) c.fillText("rank " + lanes[lane].rank, 6, y);
      else continue;
      lastY = y;
    }
  }

  function draw() {
    if (!canvas || !canvas.clientWidth) return;
    if (!view.row) view.row = fitRow();
    clamp();
    const scale = devicePixelRatio || 1;
    canvas.width = canvas.clientWidth * scale;
    canvas.height = canvas.clientHeight * scale;
    const c = canvas.getContext("2d");
    const [first, last] = visibleLanes();
    let visible = 0;
    for (let lane = first; lane < last; ++lane) for (const r of visibleRuns(lane)) ++visible;
    c.fillStyle = weft.css("--card");
    c.fillRect(0, 0, canvas.width, canvas.height);
    const many = visible > 20000;
    if (many) drawSums(c, first, last, scale);
    c.scale(scale, scale);
    c.font = "11px system-ui, 'DejaVu Sans', sans-serif";
    c.save();
    c.beginPath();
    c.rect(labelWidth, axisHeight, plotWidth(), plotHeight());
    c.clip();
    if (!many) drawOneByOne(c, first, last);
    if (!many || onlyCritical) for (let r = 0; r < count; ++r) if (critical[r] && shows(r) && end[r] >= view.t0 && begin[r] <= view.t1) outline(c, r, weft.css("--critical"), 2);
    if (onlyCritical) for (const u of criticalUses) drawArrow(c, u, weft.css("--critical"), 1.2);
    if (selected >= 0) {
      for (const u of weft.runs.into(selected)) drawArrow(c, u, weft.css("--ink"), 1.4);
      for (const u of weft.runs.outOf(selected)) drawArrow(c, u, weft.css("--accent"), 1.4);
      outline(c, selected, weft.css("--ink"), 2.5);
    }
    c.restore();
    drawAxis(c);
    canvas.dataset.visible = visible;
    status.textContent = `${weft.count(visible)} of ${weft.plural(count, "task")} visible in ${weft.plural(lanes.length, "row")}` + (ranksShown < ranks ? ` of ${ranksShown} of ${ranks} ranks` : "") + (many ? "; so many are added up by pixel: zoom in to see each." : ".") + (data.uses_left_out ? ` ${weft.count(data.uses_left_out)} small messages were left out of this page.` : "");
  }
  let waiting = false;
  function later() {
    if (waiting) return;
    waiting = true;
    requestAnimationFrame(() => { waiting = false; draw(); });
  }

  // --- Acting

  function zoom(factor, at = labelWidth + plotWidth() / 2) {
    const t = time(at);
    view.t0 = t - (t - view.t0) * factor;
    view.t1 = t + (view.t1 - t) * factor;
    later();
  }
  function zoomRows(factor, at = axisHeight + plotHeight() / 2) {
    const lane = (view.y + at - axisHeight) / view.row;
    view.row = Math.max(2, Math.min(60, view.row * factor));
    view.y = lane * view.row - (at - axisHeight);
    later();
  }
  function reset() { view = { t0: 0, t1: wall * 1.005, y: 0, row: fitRow() }; later(); }

  function runAt(px, py) {
    const lane = Math.floor((py - axisHeight + view.y) / view.row);
    if (lane < 0 || lane >= lanes.length || px < labelWidth || py < axisHeight) return -1;
    const t = time(px), slack = (1.5 * (view.t1 - view.t0)) / plotWidth();
    let best = -1;
    for (const r of visibleRuns(lane)) if (begin[r] - slack <= t && t <= end[r] + slack && (best < 0 || (begin[r] <= t && t <= end[r]))) best = r;
    return best;
  }
  function bringIntoView(r) {
    const width = Math.max(view.t1 - view.t0, 3 * (end[r] - begin[r]));
    if (begin[r] < view.t0 || end[r] > view.t1) { view.t0 = (begin[r] + end[r]) / 2 - width / 2; view.t1 = view.t0 + width; }
    if (!hasLane(r)) return;
    const y = laneOf[r] * view.row;
    if (y < view.y || y + view.row > view.y + plotHeight()) view.y = y - plotHeight() / 2;
  }
  function links(title, list, other) {
    if (!list.length) return null;
    const items = list.slice(0, 200).map((u) => make("li", {}, make("button", { type: "button", onclick: () => select(other[u]) }, `${weft.runs.title(other[u])}` + (uses.bytes[u] ? `, ${weft.bytes(uses.bytes[u])}` : ""))));
    return [make("h3", {}, `${title} (${list.length})`), make("ul", { class: "links" }, items)];
  }
  function select(r) {
    selected = r;
    canvas.dataset.selected = r;
    details.replaceChildren();
    if (r < 0) { details.append(make("p", { class: "note" }, "Choose a task to see what it waited for and who waited for it.")); later(); return; }
    bringIntoView(r);
    const rows = [["subdomain", instances[runs.instance[r]].number], ["round", runs.round[r]], ["where", `rank ${runs.rank[r]}, ${hasLane(r) ? lanes[laneOf[r]].name : "which has no row"}`], ["begin", weft.seconds(begin[r] * 1e-9)], ["took", weft.seconds(runs.duration_ns[r] * 1e-9)]];
    if (runs.bytes_received[r]) rows.push(["received", weft.bytes(runs.bytes_received[r])]);
    for (const [name, column] of Object.entries(runs.counters)) if (column[r]) rows.push(name.endsWith(", seconds") ? [name.slice(0, -", seconds".length), weft.seconds(column[r])] : [name, weft.count(column[r])]);
    if (critical[r]) rows.push(["critical path", "yes"]);
    details.append(make("h2", {}, nodes[runs.node[r]].name), make("dl", {}, rows.map(([k, v]) => [make("dt", {}, k), make("dd", {}, String(v))])),
      ...[links("Got values from", weft.runs.into(r), uses.from), links("Sent values to", weft.runs.outOf(r), uses.to)].flat().filter((e) => e));
    later();
  }
  weft.selectRun = (r) => { weft.show("timeline"); requestAnimationFrame(() => { if (!view.row) view.row = fitRow(); select(r); }); };

  function listen() {
    let drag = null;
    canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      const box = frame();
      if (event.ctrlKey) zoomRows(Math.exp(-event.deltaY * 0.002), event.clientY - box.top);
      else if (event.shiftKey) { view.y += event.deltaY || event.deltaX; later(); }
      else zoom(Math.exp(event.deltaY * 0.0015), event.clientX - box.left);
    }, { passive: false });
    canvas.addEventListener("pointerdown", (event) => { drag = { x: event.clientX, y: event.clientY, view: { ...view }, moved: false }; canvas.setPointerCapture(event.pointerId); });
    canvas.addEventListener("pointermove", (event) => {
      const box = frame();
      if (!drag) {
        const r = runAt(event.clientX - box.left, event.clientY - box.top);
        weft.tip(event, r < 0 ? "" : `${weft.runs.title(r)}\n${weft.seconds(runs.duration_ns[r] * 1e-9)} on rank ${runs.rank[r]}${critical[r] ? "\non the critical path" : ""}`);
        return;
      }
      const dx = event.clientX - drag.x, dy = event.clientY - drag.y;
      if (Math.abs(dx) + Math.abs(dy) > 4) drag.moved = true;
      const dt = (dx / plotWidth()) * (drag.view.t1 - drag.view.t0);
      view.t0 = drag.view.t0 - dt;
      view.t1 = drag.view.t1 - dt;
      view.y = drag.view.y - dy;
      later();
    });
    canvas.addEventListener("pointerup", (event) => {
      const box = frame();
      if (drag && !drag.moved) select(runAt(event.clientX - box.left, event.clientY - box.top));
      drag = null;
    });
    canvas.addEventListener("pointerleave", (event) => weft.tip(event, ""));
    canvas.addEventListener("keydown", (event) => {
      const width = view.t1 - view.t0, path = data.graph.critical_path.runs;
      const acts = { ArrowLeft: () => { view.t0 -= 0.1 * width; view.t1 -= 0.1 * width; }, ArrowRight: () => { view.t0 += 0.1 * width; view.t1 += 0.1 * width; },
        ArrowUp: () => { view.y -= 60; }, ArrowDown: () => { view.y += 60; }, "+": () => zoom(0.7), "=": () => zoom(0.7), "-": () => zoom(1 / 0.7), Home: reset, Escape: () => select(-1),
        n: () => select(path[Math.min(path.length - 1, path.indexOf(selected) + 1)]), p: () => select(path[Math.max(0, path.indexOf(selected) - 1)]) };
      if (!acts[event.key] || event.ctrlKey || event.metaKey) return;
      event.preventDefault();
      acts[event.key]();
      later();
    });
    new ResizeObserver(later).observe(canvas);
  }

  function operationLegend() {
    const used = [...new Set(operation)].sort((a, b) => a - b);
    return make("div", { class: "legend", role: "group", "aria-label": "Operations shown" }, used.map((o) => {
      const button = make("button", { type: "button", "aria-pressed": "true", onclick: () => {
        if (hidden.has(o)) hidden.delete(o); else hidden.add(o);
        button.setAttribute("aria-pressed", String(!hidden.has(o)));
        later();
      } }, make("i", { style: `background:${weft.operationColour(o)}` }), data.operations[o]);
      return button;
    }));
  }

  function build() {
    canvas = make("canvas", { class: "plot", id: "timeline", tabindex: 0, role: "application", style: `height:${Math.min(620, 30 + Math.max(90, (lanes.length <= 8 ? 45 : 26) * lanes.length))}px`, "aria-label": "Timeline. Arrow keys move, plus and minus zoom, Home shows all, n and p follow the critical path." });
    details = make("div", { class: "card", id: "task" });
    status = make("p", { class: "note", id: "timeline-status", role: "status" });
    const only = make("input", { type: "checkbox", id: "only-critical", onchange: (event) => { onlyCritical = event.target.checked; later(); } });
    const tool = make("div", { class: "tool" }, make("button", { type: "button", onclick: () => zoom(0.5) }, "Zoom in"), make("button", { type: "button", onclick: () => zoom(2) }, "Zoom out"),
      make("button", { type: "button", onclick: () => zoomRows(1.5) }, "Taller rows"), make("button", { type: "button", onclick: () => zoomRows(1 / 1.5) }, "Lower rows"), make("button", { type: "button", onclick: reset }, "All"),
      make("label", {}, only, "critical path only"));
    listen();
    select(-1);
    weft.onTheme.push(later);
    return [make("div", { class: "side" }, weft.card("Timeline", tool, canvas, operationLegend(), status, make("p", { class: "note" }, "Wheel: time; Ctrl and wheel: rows; Shift and wheel or drag: move. Red: the critical path. Keys: arrows, +, −, Home, n and p along the critical path.")), details)];
  }
  weft.views.push({ id: "timeline", title: "Timeline", build, onshow: () => later() });
})();
