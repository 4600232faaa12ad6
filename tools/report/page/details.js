// Operators, hardware, memory, MPI calls, the command: for who wants to know more.
"use strict";
(() => {
  const { data, make } = weft;
  const report = data.report;

  function operators() {
    if (!report) return null;
    const names = Object.keys(report.operations);
    const reasons = [...new Set(names.flatMap((n) => Object.entries(report.operations[n].refused).filter(([, c]) => c > 0).map(([r]) => r)))];
    const rows = names.map((n) => {
      const o = report.operations[n];
      return [n.replace("_", " "), weft.count(o.tried), weft.count(o.done), weft.percent(o.done / Math.max(1, o.tried)), weft.count(o.rolled_back), ...reasons.map((r) => weft.count(o.refused[r] || 0))];
    });
    return weft.card("Operators", make("p", { class: "note" }, "Rolled back: another thread held a vertex. Then the reasons for refusals."),
      weft.table(["operator", "tried", "done", "", "rolled back", ...reasons.map((r) => r.replaceAll("_", " "))], rows, { figures: names.map((n) => ["", `operations.${n}.tried`, `operations.${n}.done`, "", `operations.${n}.rolled_back`, ...reasons.map(() => "")]) }));
  }
  function hardware() {
    if (!data.hardware.length) return null;
    return weft.card("Hardware", weft.table(["processor", "cores", "memory", "ranks"], data.hardware.map((h) => [h.processor || "unknown", h.cores, h.memory ? weft.bytes(h.memory) : "–", { class: "text", text: h.ranks.length > 8 ? weft.plural(h.ranks.length, "rank") : h.ranks.join(", ") }])));
  }
  function memory() {
    if (!data.memory.length) return null;
    const chart = weft.chart(() => ({
      type: "scatter",
      data: { datasets: data.memory.map((m) => ({ label: "rank " + m.rank, data: m.seconds.map((x, i) => ({ x, y: m.bytes[i] / 1e6 })), showLine: true, pointRadius: 0, borderColor: `rgb(${weft.categoryColour(m.rank)})`, borderWidth: 2 })) },
      options: { scales: { x: { title: { display: true, text: "seconds" }, min: 0 }, y: { title: { display: true, text: "MB in use" }, beginAtZero: true } }, plugins: { legend: { display: data.memory.length <= 16, position: "bottom", labels: { boxWidth: 12 } } } },
    }), 300, "Memory over time");
    return weft.card("Memory over time", chart);
  }
  function calls() {
    if (!data.engine) return null;
    const rows = Object.entries(data.engine.network_calls).sort((a, b) => b[1] - a[1]).map(([name, n]) => [name, weft.count(n)]);
    const counters = Object.entries(data.engine.counters).map(([name, c]) => [name.replaceAll("_", " "), weft.digits(c.sum), weft.digits(c.min), weft.digits(c.max)]);
    return make("div", { class: "two" }, data.simulation ? null : weft.card("MPI calls", make("p", { class: "note", "data-figure": "collective_calls" }, `Collective calls in the loop: ${weft.count(data.engine.collective_calls)}`), rows.length ? weft.table(["function", "calls"], rows) : weft.empty("One process: none.")),
      counters.length ? weft.card("Counters of the engine", weft.table(["counter", "sum", "least of a rank", "most"], counters)) : null);
  }
  function simulated() {
    const text = (value) => (typeof value === "object" ? Object.entries(value).map(([k, v]) => `${k}: ${text(v)}`).join(", ") : typeof value !== "number" ? String(value) : Number.isInteger(value) ? weft.count(value) : weft.digits(value, 4));
    return weft.card("The replay", weft.table(["", ""], Object.entries(data.simulation).map(([name, value]) => [name.replaceAll("_", " "), { class: "text", text: text(value) }])));
  }
  function command() {
    if (data.simulation) return simulated();
    if (!report) return null;
    const rows = [["command", "weft " + report.arguments.join(" ")], ["version", report.version], [report.asked_complexity === null ? "complexity of the metric on the background mesh (none was asked for)" : "target complexity", weft.digits(report.target_complexity, 6)], ["threads", report.threads]];
    if (report.subdomains) rows.push(["partitioner", report.subdomains.partitioner], ["layers handed over", report.subdomains.layers]);
    return weft.card("The command", weft.table(["", ""], rows.map(([k, v]) => [k, { class: "text", text: String(v) }])));
  }
  weft.views.push({ id: "details", title: "Details", build: () => [command(), operators(), calls(), make("div", { class: "two" }, hardware(), memory())] });
})();
