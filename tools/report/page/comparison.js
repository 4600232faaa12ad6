// Two runs side by side: what got slower, and what happened to the quality.
"use strict";
(() => {
  const { data, make } = weft;
  const signed = (x) => (x > 0 ? "+" : x < 0 ? "−" : "±") + weft.seconds(Math.abs(x));
  const change = (row) => (row.a > 0 ? (row.b >= row.a ? "+" : "−") + weft.percent(Math.abs(row.b / row.a - 1)) : "–");
  const classOf = (row) => (Math.abs(row.b - row.a) < 0.02 * Math.max(row.a, row.b) ? "" : row.b > row.a ? "worse" : "better");

  function times(title, rows, what) {
    const sorted = rows.slice().sort((x, y) => Math.abs(y.b - y.a) - Math.abs(x.b - x.a)), most = Math.max(1e-12, ...sorted.map((r) => Math.max(r.a, r.b)));
    const bar = (row) => make("span", { style: "display:inline-flex;flex-direction:column;gap:2px;width:220px" },
      make("i", { style: `height:6px;border-radius:2px;background:var(--soft);width:${(100 * row.a) / most}%` }), make("i", { style: `height:6px;border-radius:2px;background:var(--accent);width:${(100 * row.b) / most}%` }));
    const table = weft.table([what, "A above B", "A", "B", "difference", ""], sorted.map((row) => [row.name, bar(row), weft.seconds(row.a), weft.seconds(row.b), { class: classOf(row), text: signed(row.b - row.a) }, change(row)]),
      { figures: sorted.map((row) => ["", "", `${row.name}.a`, `${row.name}.b`, "", ""]) });
    return weft.card(title, table);
  }

  function measures() {
    const rows = data.measures.map((m) => {
      const text = (x) => (x === null ? "–" : m.kind === "count" ? weft.count(x) : m.kind === "share" ? weft.percent(x, 2) : weft.digits(x, 4));
      const better = m.a !== null && m.b !== null && m.better !== 0 && m.a !== m.b ? (Math.sign(m.b - m.a) === m.better ? "better" : "worse") : "";
      return [m.name, text(m.a), text(m.b), { class: better, text: better }];
    });
    return weft.card("Meshes", weft.table(["", "A", "B", ""], rows));
  }

  document.getElementById("what").textContent = "· two runs compared";
  const content = document.getElementById("content"), slower = data.b.seconds > data.a.seconds * 1.02, faster = data.b.seconds < data.a.seconds * 0.98;
  const run = (name, r) => make("div", { class: "card tile" }, make("div", { class: "name" }, `${name}: ${r.name}`), make("div", { class: "figure", "data-figure": `${name}.seconds` }, weft.seconds(r.seconds)), make("div", { class: "note" }, r.about));
  content.append(...[
    make("div", { class: "card verdict" + (slower ? " missed" : "") }, make("span", { class: "mark" }, slower ? "!" : "✓"), make("div", {}, data.verdict, ...data.remarks.map((r) => make("small", {}, r)))),
    make("div", { class: "grid" }, run("A", data.a), run("B", data.b)),
    data.operations.length ? times("By operation", data.operations, "operation") : null, data.steps.length ? times("By step", data.steps, "step") : null,
    data.ranks.length ? times("By rank, without idle", data.ranks, "rank") : null, data.measures.length ? measures() : null].filter((e) => e));
  document.title = "weft: two runs compared" + (faster || slower ? "" : ", as fast");
  weft.startTheme();
  document.documentElement.dataset.ready = "";
})();
