// Histograms before and after, linear and logarithmic, and the figures beside them.
"use strict";
(() => {
  const { data, make } = weft;
  const report = data.report;
  const sets = report ? [["before", report.before, "#9aa7b4"], ["after", report.after, "#2f6fb0"]] : [];
  if (report && report.subdomains && report.subdomains.former_interface && report.subdomains.former_interface.tets > 0) sets.push(["former interface", report.subdomains.former_interface, "#e07b16"]);
  const known = sets.filter(([, m]) => m);

  const edge = (h, i) => {
    const at = h.lo + (i * (h.hi - h.lo)) / h.counts.length;
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

  /** A point at the left edge of each bin, and one at the end. */
  function points(h, logarithmicY) {
    const list = shares(h).map((y, i) => ({ x: edge(h, i), y: logarithmicY && y === 0 ? NaN : y }));
    return [...list, { x: edge(h, h.counts.length), y: list[list.length - 1].y }];
  }
  /** The lengths that count as unit. */
  const unitZone = { id: "unit", beforeDatasetsDraw(chart) {
    const { ctx, chartArea: area, scales: { x } } = chart, left = x.getPixelForValue(Math.SQRT1_2), right = x.getPixelForValue(Math.SQRT2);
    ctx.save();
    ctx.fillStyle = weft.css("--good");
    ctx.globalAlpha = 0.1;
    ctx.fillRect(left, area.top, right - left, area.height);
    ctx.restore();
  } };

  // Published histograms of other programs. Of each program the run on the fewest cores is shown at once.
  const published = data.published_curves || [];
  const programs = [...new Set(published.map((c) => c.program))];
  const fewest = (program) => Math.min(...published.filter((c) => c.program === program).map((c) => c.cores));
  const colourOf = (program) => weft.palette[(programs.indexOf(program) + 4) % weft.palette.length];
  const shownAtOnce = (curve) => curve.program !== "EPIC" && curve.cores === fewest(curve.program);

  /** A curve in % of the values in a bin of the histogram `h`, as wide as that one is at the same place. */
  function curvePoints(curve, h, logarithmicY) {
    const width = (x) => (h.logarithmic ? x * (10 ** ((h.hi - h.lo) / h.counts.length) - 1) : (h.hi - h.lo) / h.counts.length);
    return curve.densities.map((density, i) => {
      const x = Math.sqrt(curve.edges[i] * curve.edges[i + 1]), y = 100 * density * width(x);
      return { x, y: logarithmicY && y === 0 ? NaN : y };
    });
  }
  function curves(measure, h, logarithmicY) {
    return published.filter((c) => c.measure === measure).map((c) => ({ label: `${c.program}, ${c.cores} ${c.cores === 1 ? "core" : "cores"}`, data: curvePoints(c, h, logarithmicY), borderColor: colourOf(c.program), backgroundColor: "transparent", borderDash: c.cores === 1 ? [] : [5, 3], borderWidth: 1.5, pointRadius: 0, pointHitRadius: 4, hidden: !shownAtOnce(c), published: true }));
  }
  /** Of those programs whose histograms are not known the mean is a line from the bottom to the top. */
  function means(h, logarithmicY) {
    const top = Math.max(...known.flatMap(([, m]) => shares(m.quality.histogram)));
    return data.published.filter((p) => !programs.includes(p.program) && p.quality_mean !== null).map((p, i) => ({ label: `mean of ${p.program}, ${p.cores} ${p.cores === 1 ? "core" : "cores"}`, data: [{ x: p.quality_mean, y: logarithmicY ? 1e-4 : 0 }, { x: p.quality_mean, y: top }], borderColor: weft.palette[(i + 4 + programs.length) % weft.palette.length], backgroundColor: "transparent", borderDash: [2, 3], borderWidth: 2, pointRadius: 0, pointHitRadius: 4, published: true }));
  }
  const others = (group, h, logarithmicY) => (group === "quality" ? [...curves("mean_ratio", h, logarithmicY), ...means(h, logarithmicY)] : curves("edge_length", h, logarithmicY));
  const sourceOfOthers = (group) => (published.length ? " Curves of other programs: histograms published by the Unstructured Grid Adaptation Working Group; a click in the legend shows or hides one." : "") + (group === "quality" && data.published.some((p) => !programs.includes(p.program)) ? " Of programs without a published histogram the mean quality is a dotted line." : "");

  function histogram(title, group, what, unit) {
    let logarithmicX = false, logarithmicY = false;
    const chart = weft.chart(() => {
      const key = logarithmicX ? "histogram_log" : "histogram";
      const first = known[0][1][group][key];
      return {
        type: "line",
        data: { datasets: known.map(([name, m, colour]) => ({ label: name, data: points(m[group][key], logarithmicY), borderColor: colour, backgroundColor: colour + "2e", fill: name === "after", order: name === "after" ? 2 : 1, stepped: true, pointRadius: 0, pointHitRadius: 6, borderWidth: name === "before" ? 1.5 : 2 })).concat(others(group, first, logarithmicY)) },
        options: { parsing: false, interaction: { mode: "nearest", axis: "x", intersect: false },
          scales: { x: { type: logarithmicX ? "logarithmic" : "linear", min: edge(first, 0), max: edge(first, first.counts.length), title: { display: true, text: what }, afterBuildTicks: logarithmicX ? weft.logarithmicTicks : undefined, ticks: { callback: (v) => weft.digits(v, 2), autoSkip: !logarithmicX, maxTicksLimit: 11, maxRotation: 0 } }, y: { type: logarithmicY ? "logarithmic" : "linear", afterBuildTicks: logarithmicY ? weft.logarithmicTicks : undefined, ticks: { callback: (v) => weft.digits(v, 2), autoSkip: !logarithmicY }, title: { display: true, text: `% of the ${unit} in a bin` }, beginAtZero: !logarithmicY } },
          plugins: { legend: { position: "bottom", labels: { boxWidth: 12 } }, tooltip: { callbacks: { title: (c) => `${what} from ${weft.digits(c[0].parsed.x)}`, label: (c) => `${c.dataset.label}: ${weft.digits(c.parsed.y)} %` } } } },
        plugins: group === "edge_length" ? [unitZone] : [],
      };
    }, 330, title);
    const tool = make("div", { class: "tool" }, "Values:", weft.choice("values", [["linear", "linear"], ["log", "logarithmic"]], (v) => { logarithmicX = v === "log"; chart.redraw(); }),
      "Counts:", weft.choice("counts", [["linear", "linear"], ["log", "logarithmic"]], (v) => { logarithmicY = v === "log"; chart.redraw(); }));
    const note = group === "edge_length" ? "Green: unit edges. The outermost bins hold what lies beyond them." : "The outermost bins hold what lies beyond them.";
    return weft.card(title, tool, chart, make("p", { class: "note" }, note + sourceOfOthers(group)));
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
  weft.views.push({ id: "quality", title: "Quality", shown: () => known.length > 0, build });
})();
