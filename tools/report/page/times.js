// The paper's figure of the percentage breakdown, a bar for each rank and one for all; and who waited for whom.
"use strict";
(() => {
  const { data, make } = weft;
  const report = data.report;

  function breakdown() {
    let unit = "percent";
    const labels = ["all", ...data.ranks.map((r) => "rank " + r.rank)];
    const totals = [data.total, ...data.ranks].map((r) => Object.values(r.seconds).reduce((a, b) => a + b, 0));
    const value = (row, name, k) => (unit === "percent" ? (100 * row.seconds[name]) / totals[k] : k === 0 ? row.seconds[name] / data.ranks.length : row.seconds[name]);
    const few = labels.length <= 40;
    const chart = weft.chart(() => ({
      type: "bar",
      data: { labels, datasets: data.operations.map((name, o) => ({ label: name, data: [data.total, ...data.ranks].map((row, k) => value(row, name, k)), backgroundColor: weft.operationColour(o), barPercentage: few ? 0.85 : 1, categoryPercentage: few ? 0.9 : 1 })) },
      options: { indexAxis: few ? "y" : "x", interaction: { mode: "nearest", axis: few ? "y" : "x", intersect: true },
        scales: { x: { stacked: true, max: few && unit === "percent" ? 100 : undefined, title: { display: few, text: unit === "percent" ? "% of the workers' time" : "seconds of all workers of a rank" } }, y: { stacked: true, max: !few && unit === "percent" ? 100 : undefined } },
        plugins: { legend: { position: "bottom", labels: { boxWidth: 12 } }, tooltip: { callbacks: { label: (c) => `${c.dataset.label}: ${weft.digits(c.raw)}${unit === "percent" ? " %" : " s"}` } } } },
    }), few ? Math.max(260, 26 * labels.length + 110) : 460, "Time by operation and rank");
    const tool = make("div", { class: "tool" }, weft.choice("unit", [["percent", "Shares"], ["seconds", "Seconds"]], (u) => { unit = u; chart.redraw(); }),
      make("span", { class: "note" }, "“all” in seconds is the mean of the ranks. The communication thread is not included in the bars."));
    return weft.card("Time by operation", tool, chart);
  }

  function rankTable() {
    const head = ["rank", "workers", "wall", ...data.operations, "communication", "peak memory"];
    const row = (r, name) => [name, r.workers, weft.seconds(r.wall), ...data.operations.map((o) => weft.seconds(r.seconds[o])), weft.seconds(r.communication), r.peak_memory ? weft.bytes(r.peak_memory) : "–"];
    const all = [String("all"), data.total.workers, weft.seconds(data.total.wall), ...data.operations.map((o) => weft.seconds(data.total.seconds[o])), weft.seconds(data.engine.communication), data.engine.peak_rss.sum ? weft.bytes(data.engine.peak_rss.sum) : "–"];
    const figures = [["", "", "", ...data.operations.map((o) => "total.seconds." + o), "", ""], ...data.ranks.map((r) => ["", "", "", ...data.operations.map((o) => `rank.${r.rank}.${o}`), "", ""])];
    return weft.card("Table", weft.table(head, [all, ...data.ranks.map((r) => row(r, r.rank))], { figures, classOf: (r) => (r === 0 ? "own" : null) }));
  }

  function waits() {
    if (!data.waiting) return null;
    const ranks = data.waiting.ranks.slice(0, 40).map((w) => [w.rank, w.for, weft.seconds(w.seconds), weft.count(w.count)]);
    const subdomains = data.waiting.subdomains.slice(0, 40).map((w) => [w.subdomain, w.for, weft.seconds(w.seconds), weft.count(w.count)]);
    const none = weft.empty("No waiting was recorded.");
    return make("div", { class: "two" },
      weft.card("Subdomains that waited for a neighbour", make("p", { class: "note" }, "A worker may have done other work meanwhile."), subdomains.length ? weft.table(["subdomain", "for", "waited", "times"], subdomains) : none),
      weft.card("The same, by rank", make("p", { class: "note" }, "Summed over the subdomains that a rank had."), ranks.length ? weft.table(["rank", "for", "waited", "times"], ranks) : none.cloneNode(true)));
  }

  function commandCard() {
    if (!report) return null;
    const rows = Object.entries(report.seconds).map(([name, s]) => [name, weft.seconds(s)]);
    return weft.card("The whole command", weft.table(["step", "time"], rows));
  }
  function stagesCard() {
    if (!report) return null;
    const rows = report.stages.map((stage) => [stage.name, weft.seconds(stage.seconds), weft.count(stage.vertices), weft.count(stage.tets)]);
    return rows.length ? weft.card("Stages of the adaptation", weft.table(["stage", "time", "vertices", "tets"], rows)) : null;
  }

  function path() {
    if (!data.critical_path) return null;
    const p = data.critical_path;
    const rows = p.by_operation.slice().sort((a, b) => b.seconds - a.seconds).map((o) => [o.operation, weft.seconds(o.seconds), weft.percent(o.seconds / p.seconds), weft.count(o.runs)]);
    return weft.card("Critical path", make("p", { class: "note" }, `The longest chain of dependent tasks: ${weft.seconds(p.seconds)} of ${weft.seconds(p.wall)}. More workers cannot make the run shorter than this chain.`), weft.table(["operation", "time", "share", "runs"], rows));
  }

  const build = () => (data.total ? [breakdown(), make("div", { class: "two" }, path(), commandCard()), waits(), rankTable(), stagesCard()] : [make("div", { class: "two" }, commandCard(), stagesCard())]);
  weft.views.push({ id: "time", title: "Time", build });
})();
