// Histograms before and after, linear and logarithmic, and the figures beside them.
"use strict";
(() => {
  const { data, make } = weft;
  const report = data.report;
  const sets = [["before", report.before, "#9aa7b4"], ["after", report.after, "#2f6fb0"]];
  if (report.subdomains && report.subdomains.former_interface && report.subdomains.former_interface.tets > 0) sets.push(["former interface", report.subdomains.former_interface, "#e07b16"]);
  const known = sets.filter(([, m]) => m);

  const middle = (h, i) => {
    const at = h.lo + ((i + 0.5) * (h.hi - h.lo)) / h.counts.length;
    return h.logarithmic ? 10 ** at : at;
  };
  /** Shares of all values in each bin, those outside in the first and the last. */
  function shares(h) {
    const counts = h.counts.slice();
    counts[0] += h.below;
    counts[counts.length - 1] += h.above;
    const all = Math.max(1, counts.reduce((a, b) => a + b, 0));
    return counts.map((c) => (100 * c) / all);
  }

  function histogram(title, group, what, unit) {
    let logarithmicX = false, logarithmicY = false;
    const chart = weft.chart(() => {
      const key = logarithmicX ? "histogram_log" : "histogram";
      const first = known[0][1][group][key];
      return {
        type: "line",
        data: { labels: first.counts.map((_, i) => middle(first, i)), datasets: known.map(([name, m, colour]) => ({ label: name, data: shares(m[group][key]).map((y) => (logarithmicY && y === 0 ? null : y)), borderColor: colour, backgroundColor: colour + "33", fill: true, stepped: "middle", pointRadius: 0, borderWidth: 2 })) },
        options: { interaction: { mode: "index", intersect: false }, scales: { x: { title: { display: true, text: what }, ticks: { callback: (v, i) => weft.digits(middle(first, i), 2), maxTicksLimit: 11 } }, y: { type: logarithmicY ? "logarithmic" : "linear", title: { display: true, text: `% of the ${unit} in a bin` }, beginAtZero: !logarithmicY } },
          plugins: { legend: { position: "bottom", labels: { boxWidth: 12 } }, tooltip: { callbacks: { title: (c) => `${what} about ${weft.digits(c[0].label * 1)}`, label: (c) => `${c.dataset.label}: ${weft.digits(c.raw)} %` } } } },
      };
    }, 330, title);
    const tool = make("div", { class: "tool" }, weft.choice("values", [["linear", "Linear"], ["log", "Logarithmic values"]], (v) => { logarithmicX = v === "log"; chart.redraw(); }),
      weft.choice("counts", [["linear", "Linear"], ["log", "Logarithmic counts"]], (v) => { logarithmicY = v === "log"; chart.redraw(); }));
    return weft.card(title, tool, chart);
  }

  function figures() {
    const rows = [["tets", (m) => weft.count(m.tets)], ["vertices", (m) => weft.count(m.vertices)], ["complexity", (m) => weft.digits(m.complexity, 4)],
      ["quality: mean", (m) => m.quality.mean.toFixed(4), "quality.mean"], ["quality: 1 % quantile", (m) => m.quality["quantile_0.01"].toFixed(4), "quality.quantile_0.01"],
      ["quality: 0.1 % quantile", (m) => m.quality["quantile_0.001"].toFixed(4)], ["quality: worst", (m) => weft.digits(m.quality.min), "quality.min"],
      ["tets below 0.1", (m) => weft.percent(m.quality["share_below_0.1"], 3)], ["tets below 0.2", (m) => weft.percent(m.quality["share_below_0.2"], 3)], ["tets above 0.8", (m) => weft.percent(m.quality["share_above_0.8"])],
      ["edges: unit", (m) => weft.percent(m.edge_length.share_unit, 2)], ["edges: short", (m) => weft.percent(m.edge_length.share_short, 2)], ["edges: long", (m) => weft.percent(m.edge_length.share_long, 2)],
      ["edges: shortest", (m) => weft.digits(m.edge_length.min)], ["edges: longest", (m) => weft.digits(m.edge_length.max)]];
    return weft.card("Figures", weft.table(["", ...known.map(([name]) => name)], rows.map(([name, f]) => [name, ...known.map(([, m]) => f(m))]),
      { figures: rows.map(([, , id]) => ["", ...known.map(([name]) => (id ? `${name}.${id}` : ""))]) }),
    make("p", { class: "note" }, "Quality is the mean ratio in the metric, 1 for a regular tet of unit edges. Unit edges are between 1/√2 and √2 long in the metric."));
  }

  const build = () => [make("div", { class: "two" }, histogram("Quality of the tets", "quality", "mean ratio", "tets"), histogram("Length of the edges", "edge_length", "length in the metric", "edges")), figures(), weft.publishedCard()];
  weft.views.push({ id: "quality", title: "Quality", build });
})();
