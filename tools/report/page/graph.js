// The task graph: as planned, by rounds, and the network of subdomains. What is clicked is explained beside it.
"use strict";
(() => {
  const { data, make } = weft;
  if (!data.graph) return;
  const graph = data.graph, plan = graph.graph, runs = graph.runs, uses = graph.uses;
  const colour = (node) => weft.operationColour(data.operation_of_node[node]);
  const critical = new Set(graph.critical_path ? graph.critical_path.runs : []);
  let details, drawing;

  // --- Sums

  function sumOf(list) {
    let seconds = 0, longest = -1;
    for (const r of list) { seconds += runs.duration_ns[r] * 1e-9; if (longest < 0 || runs.duration_ns[r] > runs.duration_ns[longest]) longest = r; }
    return { count: list.length, seconds, longest };
  }
  function grouped(key) {
    const groups = new Map();
    for (let r = 0; r < runs.node.length; ++r) { const k = key(r); if (!groups.has(k)) groups.set(k, []); groups.get(k).push(r); }
    return groups;
  }
  const ofNode = grouped((r) => runs.node[r]), ofCell = grouped((r) => runs.round[r] * 1000 + runs.node[r]), ofInstance = grouped((r) => runs.instance[r]);
  const rounds = [...new Set(runs.round)].sort((a, b) => a - b);

  function explain(title, rows, list, more = []) {
    const sum = sumOf(list);
    const all = [["runs", weft.count(sum.count)], ["time", weft.seconds(sum.seconds)]];
    if (sum.longest >= 0) all.push(["mean", weft.seconds(sum.seconds / sum.count)], ["longest", weft.seconds(runs.duration_ns[sum.longest] * 1e-9)], ["on the critical path", weft.count(list.filter((r) => critical.has(r)).length)]);
    details.replaceChildren(make("h2", {}, title), make("dl", {}, [...rows, ...all].map(([k, v]) => [make("dt", {}, k), make("dd", {}, String(v))])));
    if (sum.longest >= 0 && weft.selectRun) details.append(make("p", {}, make("span", { class: "tool" }, make("button", { type: "button", onclick: () => weft.selectRun(sum.longest) }, "Longest run in the timeline"))));
    details.append(...more);
  }
  const button = (label, act) => ({ class: "box", role: "button", tabindex: 0, "aria-label": label, onclick: act, onkeydown: (e) => { if (e.key === "Enter" || e.key === " ") { e.preventDefault(); act(); } } });
  const svg = (width, height, label, ...children) => make("svg", { class: "plot", viewBox: `0 0 ${width} ${height}`, role: "group", "aria-label": label, style: `max-height:780px` }, ...children);

  // --- The plan

  /** Columns: as far from the start as the longest way within a round. */
  function columnsOf() {
    const forward = plan.edges.filter((e) => !e.next_round && e.kind !== "wake");
    const column = plan.nodes.map(() => 0);
    for (let pass = 0; pass < plan.nodes.length; ++pass) for (const e of forward) if (e.from !== e.to && column[e.to] < column[e.from] + 1 && column[e.from] + 1 < plan.nodes.length) column[e.to] = column[e.from] + 1;
    for (const e of plan.edges) if (e.kind === "wake") column[e.to] = Math.max(0, column[e.from] - 1);
    return column;
  }
  function drawPlan() {
    const column = columnsOf(), width = 122, height = 46, stepX = 160, stepY = 96, rows = new Map(), at = [];
    plan.nodes.forEach((n, i) => { const row = rows.get(column[i]) || 0; rows.set(column[i], row + 1); at.push([20 + column[i] * stepX, 60 + row * stepY]); });
    const total = [40 + (Math.max(...column) + 1) * stepX, 110 + Math.max(...rows.values()) * stepY];
    const woken = new Set(plan.edges.filter((e) => e.kind === "wake").map((e) => e.to));
    woken.forEach((n) => { at[n][0] += 0.5 * stepX; });
    /** From box to box: to the right, up from a node that was woken, or below all others to an earlier box. */
    function way(e) {
      const [x0, y0] = at[e.from], [x1, y1] = at[e.to], low = total[1] - 8;
      if (woken.has(e.to)) return `M${x0 + width / 2},${y0 + height} C${x0 + width / 2},${y1 + height / 2} ${x1 + width + 20},${y1 + height / 2} ${x1 + width},${y1 + height / 2}`;
      if (woken.has(e.from)) return `M${x0 + width / 3},${y0} L${x1 + 0.8 * width},${y1 + height}`;
      if (e.next_round || x1 <= x0) return `M${x0 + width / 2},${y0 + height} C${x0 + width / 2},${low + 20} ${x1 + width / 6 - 60},${low + 20} ${x1 + width / 6},${y1 + height}`;
      return `M${x0 + width},${y0 + height / 2} C${x0 + width + 32},${y0 + height / 2} ${x1 - 32},${y1 + height / 2} ${x1},${y1 + height / 2}`;
    }
    const edges = plan.edges.map((e) => make("path", { class: "edge", d: way(e), "marker-end": "url(#arrow)", "stroke-width": 1.6, "stroke-dasharray": e.kind === "remote" ? "6 4" : e.kind === "wake" ? "2 4" : null },
      make("title", {}, `${e.name} (${e.kind}${e.next_round ? ", next round" : ""}${e.value_type ? ": " + e.value_type : ""})`)));
    const boxes = plan.nodes.map((n, i) => make("g", { ...button(n.name, () => explain(n.name, [["kind", n.kind]], ofNode.get(i) || [], edgesOf(i))), "data-node": i },
      make("rect", { x: at[i][0], y: at[i][1], width, height, rx: 9, fill: colour(i), "fill-opacity": 0.18, stroke: colour(i), "stroke-width": 2 }),
      make("text", { x: at[i][0] + width / 2, y: at[i][1] + 20, "text-anchor": "middle" }, n.name),
      make("text", { class: "faint", x: at[i][0] + width / 2, y: at[i][1] + 36, "text-anchor": "middle" }, weft.seconds(sumOf(ofNode.get(i) || []).seconds))));
    drawing.replaceChildren(svg(total[0], total[1], "Planned graph of a subdomain", arrows(), ...edges, ...boxes), make("p", { class: "note" }, "What each subdomain does. Solid: within the subdomain; dashed: to its neighbours, between ranks by messages; dotted: wakes a subdomain that rests. Below: on to the next round."));
  }
  const arrows = () => make("defs", {}, make("marker", { id: "arrow", viewBox: "0 0 10 10", refX: 9, refY: 5, markerWidth: 7, markerHeight: 7, orient: "auto-start-reverse" }, make("path", { d: "M0,0 L10,5 L0,10 z", fill: weft.css("--soft") })));
  function edgesOf(node) {
    const list = plan.edges.filter((e) => e.from === node || e.to === node).map((e) => make("li", {}, `${e.name} (${e.kind})`));
    return [make("h3", {}, "Edges"), make("ul", { class: "links" }, list)];
  }

  // --- By rounds

  function drawRounds() {
    const stepX = Math.max(92, Math.min(170, 1000 / rounds.length)), stepY = 58, left = 150, box = [stepX - 40, 34];
    const place = (round, node) => [left + rounds.indexOf(round) * stepX, 40 + node * stepY];
    const width = left + rounds.length * stepX + 10, height = 46 + plan.nodes.length * stepY;
    const most = Math.max(...[...ofCell.values()].map((l) => sumOf(l).seconds));
    const between = new Map();
    uses.edge.forEach((e, u) => {
      const a = runs.round[uses.from[u]] * 1000 + runs.node[uses.from[u]], b = runs.round[uses.to[u]] * 1000 + runs.node[uses.to[u]], key = a + ">" + b;
      const entry = between.get(key) || { a, b, bytes: 0, values: 0, remote: plan.edges[e].kind === "remote", name: plan.edges[e].name };
      entry.bytes += uses.bytes[u];
      ++entry.values;
      between.set(key, entry);
    });
    const mostBytes = Math.max(1, ...[...between.values()].map((e) => e.bytes));
    const edges = [...between.values()].map((e) => {
      const [x0, y0] = place(Math.floor(e.a / 1000), e.a % 1000), [x1, y1] = place(Math.floor(e.b / 1000), e.b % 1000);
      const from = [x0 + box[0], y0 + box[1] / 2], to = x1 > x0 ? [x1, y1 + box[1] / 2] : [x1 + box[0], y1 + box[1] / 2], reach = x1 > x0 ? (x1 - x0 - box[0]) / 2 : 30;
      return make("path", { class: "edge", d: `M${from} C${from[0] + reach},${from[1]} ${to[0] + (x1 > x0 ? -reach : reach)},${to[1]} ${to}`, "stroke-width": 1 + 6 * (e.bytes / mostBytes), "stroke-opacity": 0.55, "stroke-dasharray": e.remote ? "6 3" : null },
        make("title", {}, `${e.name}: ${weft.plural(e.values, "value")}${e.bytes ? ", " + weft.bytes(e.bytes) : ""}`));
    });
    const cells = [...ofCell.entries()].map(([key, list]) => {
      const round = Math.floor(key / 1000), node = key % 1000, [x, y] = place(round, node), sum = sumOf(list), isCritical = list.some((r) => critical.has(r));
      return make("g", button(`${plan.nodes[node].name}, round ${round}`, () => explain(plan.nodes[node].name, [["round", round]], list)),
        make("rect", { x, y, width: box[0], height: box[1], rx: 7, fill: colour(node), "fill-opacity": 0.15 + (0.8 * sum.seconds) / most, stroke: isCritical ? weft.css("--critical") : colour(node), "stroke-width": isCritical ? 2.5 : 1 }),
        make("text", { x: x + box[0] / 2, y: y + 22, "text-anchor": "middle", style: sum.seconds > 0.55 * most ? "fill:#fff" : null }, weft.seconds(sum.seconds)));
    });
    const names = plan.nodes.map((n, i) => make("text", { x: left - 14, y: 40 + i * stepY + 22, "text-anchor": "end" }, n.name));
    const titles = rounds.map((r) => make("text", { class: "faint", x: left + rounds.indexOf(r) * stepX + box[0] / 2, y: 24, "text-anchor": "middle" }, `round ${r}`));
    drawing.replaceChildren(make("div", { style: "overflow-x:auto" }, svg(width, height, "Executed graph by rounds", ...edges, ...cells, ...names, ...titles)), make("p", { class: "note" }, "All runs of a node in a round are one box, stronger where they took longer; red: on the critical path. Lines: values passed on, dashed between subdomains, wider for more bytes."));
  }

  // --- Subdomains

  function drawSubdomains() {
    const size = 900, centre = size / 2, order = graph.instances.map((_, i) => i).filter((i) => ofInstance.has(i)).sort((a, b) => graph.instances[a].rank - graph.instances[b].rank || graph.instances[a].number - graph.instances[b].number);
    const radius = 0.42 * size, place = new Map(order.map((i, k) => [i, [centre + radius * Math.sin((2 * Math.PI * k) / order.length), centre - radius * Math.cos((2 * Math.PI * k) / order.length)]]));
    const links = new Map();
    graph.network.from.forEach((from, l) => {
      const to = graph.network.to[l], key = Math.min(from, to) + ">" + Math.max(from, to), entry = links.get(key) || { a: Math.min(from, to), b: Math.max(from, to), bytes: 0 };
      entry.bytes += graph.network.bytes[l];
      links.set(key, entry);
    });
    const mostBytes = Math.max(1, ...[...links.values()].map((e) => e.bytes)), time = new Map(order.map((i) => [i, sumOf(ofInstance.get(i)).seconds])), most = Math.max(...time.values());
    const lines = [...links.values()].filter((e) => place.has(e.a) && place.has(e.b)).map((e) => {
      const line = make("path", { class: "edge", d: `M${place.get(e.a)} Q${centre},${centre} ${place.get(e.b)}`, "stroke-width": 0.6 + 4 * (e.bytes / mostBytes), "stroke-opacity": 0.35 });
      line.link = e;
      return line;
    });
    const room = (2 * Math.PI * radius) / order.length;
    const rank = (i) => graph.instances[i].rank;
    function choose(i) {
      for (const line of lines) {
        const mine = line.link.a === i || line.link.b === i;
        line.setAttribute("stroke-opacity", mine ? 0.95 : 0.08);
        line.style.stroke = mine ? weft.css("--accent") : "";
      }
      const neighbours = [...links.values()].filter((e) => e.a === i || e.b === i).sort((a, b) => b.bytes - a.bytes);
      const list = neighbours.map((e) => { const other = e.a === i ? e.b : e.a; return make("li", {}, make("button", { type: "button", onclick: () => choose(other) }, `subdomain ${graph.instances[other].number}: ${weft.bytes(e.bytes)}`)); });
      const by = new Map();
      for (const r of ofInstance.get(i)) { const o = data.operation_of_node[runs.node[r]]; by.set(o, (by.get(o) || 0) + runs.duration_ns[r] * 1e-9); }
      explain(`Subdomain ${graph.instances[i].number}`, [["rank", rank(i)], ...[...by].sort((a, b) => b[1] - a[1]).map(([o, s]) => [data.operations[o], weft.seconds(s)])], ofInstance.get(i), [make("h3", {}, `Neighbours (${neighbours.length})`), make("ul", { class: "links" }, list)]);
    }
    const circles = order.map((i, k) => {
      const [x, y] = place.get(i), r = Math.max(3, Math.min(0.45 * room, 22) * Math.sqrt(0.25 + (0.75 * time.get(i)) / most)), angle = (2 * Math.PI * k) / order.length;
      const hot = ofInstance.get(i).some((run) => critical.has(run));
      const label = room > 13 ? make("text", { class: "faint", x: centre + (radius + 34) * Math.sin(angle), y: centre - (radius + 34) * Math.cos(angle) + 4, "text-anchor": "middle" }, graph.instances[i].number) : null;
      return make("g", { ...button(`Subdomain ${graph.instances[i].number}`, () => choose(i)), "data-subdomain": graph.instances[i].number }, make("circle", { cx: x, cy: y, r, fill: `rgb(${weft.categoryColour(rank(i))})`, stroke: hot ? weft.css("--critical") : "none", "stroke-width": 2.5 }), label);
    });
    drawing.replaceChildren(svg(size, size, "Network of subdomains", ...lines, ...circles), make("p", { class: "note" }, "A circle a subdomain, larger where it worked longer, coloured by rank; red rim: on the critical path. Lines: bytes exchanged."));
  }

  const drawings = { plan: drawPlan, rounds: drawRounds, subdomains: drawSubdomains };
  let shown = "plan";
  function draw() {
    details.replaceChildren(make("p", { class: "note" }, "Choose a box to see its figures."));
    drawings[shown]();
  }
  function build() {
    details = make("div", { class: "card", id: "graph-details" });
    drawing = make("div", { id: "graph-drawing" });
    weft.onTheme.push(draw);
    const tool = make("div", { class: "tool" }, weft.choice("graph", [["plan", "Planned"], ["rounds", "Executed, by rounds"], ["subdomains", "Executed, by subdomains"]], (s) => { shown = s; draw(); }));
    draw();
    return [make("div", { class: "side" }, weft.card("Task graph", tool, drawing), details)];
  }
  weft.views.push({ id: "graph", title: "Graph", build });
})();
