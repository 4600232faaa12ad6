// What is left to do, round by round.
"use strict";
(() => {
  const { data, make } = weft;
  const rounds = data.convergence;
  const names = rounds.length ? Object.keys(rounds[0].counters) : [];

  function counters() {
    const chart = weft.chart(() => ({
      type: "line",
      data: { labels: rounds.map((r) => r.round), datasets: names.map((name, i) => ({ label: name, data: rounds.map((r) => (r.counters[name] > 0 ? r.counters[name] : null)), borderColor: weft.palette[i % weft.palette.length], backgroundColor: weft.palette[i % weft.palette.length], spanGaps: true, pointRadius: 4 })) },
      options: { interaction: { mode: "index", intersect: false }, scales: { x: { title: { display: true, text: "round" } }, y: { type: "logarithmic", title: { display: true, text: "sum over the subdomains" } } }, plugins: { legend: { position: "bottom", labels: { boxWidth: 12 } }, tooltip: { callbacks: { label: (c) => `${c.dataset.label}: ${weft.count(c.raw)}` } } } },
    }), 340, "Counters by round");
    return weft.card("What the nodes counted", chart);
  }
  function table() {
    const head = ["round", "seconds of work", ...names];
    const rows = rounds.map((r) => [r.round, weft.seconds(r.seconds), ...names.map((n) => weft.count(r.counters[n]))]);
    return weft.card("The same as numbers", weft.table(head, rows, { figures: rounds.map((r) => ["", `round.${r.round}.seconds`, ...names.map((n) => `round.${r.round}.${n}`)]) }));
  }
  weft.views.push({ id: "convergence", title: "Convergence", shown: () => rounds.length > 0, build: () => [names.length ? counters() : null, table()] });
})();
