// What is left to do, step by step.
"use strict";
(() => {
  const { data, make } = weft;
  const rounds = data.convergence, left = data.left || [];
  const names = rounds.length ? Object.keys(rounds[0].counters) : [];
  const isWhole = (s) => s.everything ?? s.step === 0;
  const begins = left.filter(isWhole).map((s) => s.step);
  const last = begins.at(-1) ?? 0;
  const phaseOf = (step) => begins.filter((begin) => begin <= step).length;
  const stepName = (s) => (begins.length > 1 ? `phase ${phaseOf(s.step)}, ` : "") + (isWhole(s) ? "interior" : `shift ${s.step - begins[phaseOf(s.step) - 1]}`);
  const wrong = [["long edges", 0], ["short edges", 1], ["poor tets", 2]];
  const parts = [["interior", []], ["interface", [6, 4]]];

  const dashes = [[], [7, 5], [2, 4], [10, 3, 2, 3]];

  /** Counts on a logarithmic axis, where nothing has no place. */
  function lines(title, axes, labels, datasets) {
    return weft.chart(() => ({
      type: "line",
      data: { labels, datasets: datasets.map(({ label, values, colour, dash }) => ({ label, data: values.map((v) => (v > 0 ? v : null)), borderColor: colour, backgroundColor: colour, borderDash: dash, spanGaps: true, pointRadius: 4 })) },
      options: { interaction: { mode: "index", intersect: false }, scales: { x: { title: { display: true, text: axes[0] } }, y: { type: "logarithmic", title: { display: true, text: axes[1] } } }, plugins: { legend: { position: "bottom", labels: { boxWidth: 34, usePointStyle: true, pointStyle: "line", generateLabels: (chart) => Chart.defaults.plugins.legend.labels.generateLabels(chart).map((item) => ({ ...item, lineWidth: 3, lineDash: datasets[item.datasetIndex].dash, pointStyle: "line" })) } }, tooltip: { callbacks: { label: (c) => `${c.dataset.label}: ${weft.count(c.raw)}` } } } },
    }), 340, title);
  }

  function whatIsLeft() {
    const datasets = parts.flatMap(([part, dash]) => wrong.map(([what, i]) => ({ label: `${what}, ${part}`, values: left.map((s) => s[part][what]), colour: weft.palette[i], dash })));
    const head = ["after", "subdomains adapted", ...parts.flatMap(([part]) => ["tets", ...wrong.map(([what]) => what)].map((what) => `${what}, ${part}`))];
    const row = (s) => [stepName(s), weft.count(s.subdomains), ...parts.flatMap(([part]) => ["tets", ...wrong.map(([what]) => what)].map((what) => weft.count(s[part][what])))];
    const figure = (s) => ["", `left.${s.step}.subdomains`, ...parts.flatMap(([part]) => ["tets", ...wrong.map(([what]) => what)].map((what) => `left.${s.step}.${part}.${what}`))];
    return weft.card("Remaining defects", lines("Remaining defects", ["after", "in the whole mesh"], left.map(stepName), datasets),
      begins.length > 1 ? make("p", { class: "note" }, "The first phase adapted everything, including the interfaces, to a coarser metric; each later phase to a finer one, the last to the requested one, to which all counts refer.") : null,
      make("p", { class: "note" }, "Long and short: beyond √2 and 1/√2 in the metric, estimated from the edges of some hundred vertices of each subdomain. Poor: quality below 0.4, which the last stage of an adaptation repairs. Interface (dashed): tets and edges with a vertex that is or was on an interface. An edge on the current interface counts in each of its subdomains."),
      weft.table(head, left.map(row), { figures: left.map(figure) }));
  }
  function counters() {
    // What is sent is received: lines of the same numbers are one, which is called by all their names.
    const column = (name) => rounds.map((r) => r.counters[name]).join();
    const same = (name) => names.filter((other) => column(other) === column(name));
    const datasets = names.filter((name) => same(name)[0] === name).map((name, i) => ({ label: same(name).join(" and "), values: rounds.map((r) => r.counters[name]), colour: weft.palette[i % weft.palette.length], dash: dashes[i % dashes.length] }));
    return weft.card("What the shifts moved", lines("Counters by round", ["round", "sum over the subdomains"], rounds.map((r) => r.round), datasets),
      make("p", { class: "note" }, (last > 0 ? `Round ${last} is the first shift of the last phase; earlier rounds are of coarse meshes.` : "Round 0 is the first shift, and so on.") + " Lines end at zero, which a logarithmic axis cannot show."));
  }
  function table() {
    const head = ["round", "work", ...names];
    const rows = rounds.map((r) => [r.round, weft.seconds(r.seconds), ...names.map((n) => weft.count(r.counters[n]))]);
    return weft.card("Table", make("p", { class: "note" }, `Work: of all workers; the adaptation of the interior is in that of round${begins.length > 1 ? "s" : ""} ${begins.join(", ") || 0}.`), weft.table(head, rows, { figures: rounds.map((r) => ["", `round.${r.round}.seconds`, ...names.map((n) => `round.${r.round}.${n}`)]) }));
  }
  const ofRecording = () => (data.simulation ? weft.card("", make("p", { class: "note" }, "What tasks counted was counted when they were recorded; their times are simulated.")) : null);
  weft.views.push({ id: "convergence", title: "Convergence", shown: () => rounds.length > 0, build: () => [ofRecording(), left.length ? whatIsLeft() : null, names.length ? counters() : null, table()] });
})();
