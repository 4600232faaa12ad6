// The outcome, its cost and its time, in this order.
"use strict";
(() => {
  const { data, make } = weft;
  const report = data.report, simulation = data.simulation, { after, before } = report || {};

  const tile = (name, figure, id, note) => make("div", { class: "card tile" }, make("div", { class: "name" }, name),
    make("div", { class: "figure", "data-figure": id }, figure), make("div", { class: "note" }, note));

  function workers() {
    if (!data.total) return weft.plural(report.threads, "thread");
    return weft.plural(data.ranks.length, "rank") + ", " + weft.plural(data.total.workers, "worker");
  }

  /** Of a run that was simulated, which made no mesh. */
  function simulatedVerdict() {
    const s = simulation, recording = `Replay of ${s.graph}, recorded in ${weft.seconds(s.recorded_seconds)}`;
    const made = [[s.copies, "times the mesh"], [s.split, "times the subdomains"], [s.grow, "times the tets in each"]].filter(([n]) => n !== 1).map(([n, what]) => `${weft.digits(n)} ${what}`);
    const tasks = [s.slowdown !== 1 ? `${weft.digits(s.slowdown)} times as slow` : null, s.processor_times ? "of processor times" : null].filter((t) => t).join(", ");
    return make("div", { class: "card verdict simulated" }, make("span", { class: "mark", "aria-hidden": "true" }, "≈"),
      make("div", {}, `Simulated, not measured: ${weft.seconds(s.seconds)} on ${weft.plural(s.ranks, "rank")} of ${weft.plural(s.threads, "thread")}`,
        make("small", {}, `${recording}${made.length ? ", with " + made.join(" and ") : ""}. Network ${s.network}; balancer ${s.balancer}${tasks ? "; tasks " + tasks : ""}. All times here are those of the adaptation's loop on the simulated ranks.`)));
  }
  function simulatedTiles() {
    const s = simulation, most = Math.max(...data.ranks.map((r) => r.peak_memory));
    const from = { given: "as given", recorded: "of the recording's memory", assumed: "assumed" }[s.subdomain_bytes_from];
    return [
      tile("Time, simulated", weft.seconds(s.seconds), "simulation.seconds", `the end was found ${weft.seconds(Math.max(0, s.run_seconds - s.seconds))} later`),
      tile("Efficiency", weft.percent(s.efficiency), "simulation.efficiency", `of ${weft.plural(s.ranks * s.threads, "core")}; work ${weft.seconds(s.work_seconds)}`),
      tile("Subdomains", weft.count(s.subdomains), "simulation.subdomains", `${weft.count(s.tasks)} tasks; at most ${weft.plural(s.most_subdomains, "subdomain")} on a rank; the largest works ${weft.seconds(s.largest_subdomain_seconds)}`),
      tile("Memory of a rank", weft.bytes(most), "simulation.memory", `at most, by its subdomains: ${weft.bytes(s.subdomain_bytes)} each, ${from}`),
    ];
  }

  function verdict() {
    const met = report.goal_met;
    const text = `${weft.count(after.tets)} tets, ${weft.percent(after.edge_length.share_unit)} unit edges, in ${weft.seconds(report.seconds.total)}`;
    const lines = [...(report.left_as_is ? [`The mesh fits its metric and was left as it is: ${weft.percent(report.left_as_is.share_short)} of the edges of its tets are too short, ${weft.percent(report.left_as_is.share_long, 2)} too long.`] : []), ...report.goals_missed.map((g) => "Missed: " + g), ...(report.ended_by === "interrupted" ? ["Interrupted by the user."] : [])];
    return make("div", { class: "card verdict" + (met ? "" : " missed") }, make("span", { class: "mark", "aria-hidden": "true" }, met ? "✓" : "!"),
      make("div", {}, (met ? "Goal met: " : "Goal not met: ") + text, make("small", {}, lines.length ? lines.join(" ") : `On ${workers()}${report.subdomains ? ", in " + weft.plural(report.subdomains.subdomains, "subdomain") : ""}.`)));
  }

  function meshTiles() {
    const rate = report.output.tets / Math.max(1e-9, report.seconds.adapt);
    return [
      tile("Time", weft.seconds(report.seconds.total), "seconds.total", report.left_as_is ? `finding that it fits ${weft.seconds(report.seconds.adapt)}` : `adapting ${weft.seconds(report.seconds.adapt)}: ${weft.count(rate)} tets a second`),
      tile("Tets", weft.count(report.output.tets), "output.tets", `from ${weft.count(report.input.tets)}; ${weft.count(report.output.vertices)} vertices`),
      tile("Mean quality", after.quality.mean.toFixed(3), "after.quality.mean", `worst 1 % below ${after.quality["quantile_0.01"].toFixed(3)}, worst ${weft.digits(after.quality.min, 2)}` + (before ? `; before ${before.quality.mean.toFixed(3)}` : "")),
      tile("Unit edges", weft.percent(after.edge_length.share_unit), "after.edge_length.share_unit", before ? `before ${weft.percent(before.edge_length.share_unit)}` : "length in [0.71, 1.41] of the metric"),
    ];
  }

  function tiles() {
    const list = simulation ? simulatedTiles() : meshTiles();
    if (data.engine) {
      const sent = data.engine.traffic, bytes = Object.values(sent).reduce((s, t) => s + t.sent.bytes, 0);
      const messages = Object.values(sent).reduce((s, t) => s + t.sent.messages, 0);
      list.push(tile("Balance", weft.percent(1 - data.engine.balance_saving, 0), "balance", data.engine.verdict));
      list.push(tile("Sent between ranks", weft.bytes(bytes), "bytes_sent", `${weft.count(messages)} messages, ${weft.count(data.engine.collective_calls)} collective calls`));
    }
    if (data.critical_path) {
      const path = data.critical_path, most = path.by_operation.reduce((a, b) => (a.seconds > b.seconds ? a : b));
      list.push(tile("Critical path", weft.seconds(path.seconds), "critical_path.seconds", `${weft.percent(path.share_of_wall, 0)} of the time; mostly ${most.operation}`));
    }
    if (!report) return make("div", { class: "grid" }, list);
    const ranks = data.engine && data.engine.peak_rss, memory = (ranks && ranks.sum) || report.peak_memory_bytes;  // of simulated ranks: that of their process
    list.push(tile("Peak memory", weft.bytes(memory), "peak_memory", data.ranks.length > 1 && ranks.max ? `at most ${weft.bytes(ranks.max)} on a rank` : `${weft.count(memory / Math.max(1, report.output.tets))} bytes a tet`));
    return make("div", { class: "grid" }, list);
  }

  /** One bar of shares, labelled where there is room. */
  function shareBar(parts, total) {
    return make("div", { class: "bar", role: "img", "aria-label": parts.map((p) => `${p.name} ${weft.percent(p.value / total)}`).join(", ") },
      parts.filter((p) => p.value > 0).map((p) => make("span", { class: p.name === "idle" ? "idle" : null, title: `${p.name}: ${weft.seconds(p.value)}, ${weft.percent(p.value / total)}`,
        style: `width:${(100 * p.value) / total}%;background:${p.colour}` }, p.value / total > 0.05 ? weft.percent(p.value / total, 0) : "")));
  }

  function timeCard() {
    const holder = make("div");
    const draw = () => {
      holder.replaceChildren();
      if (data.total) {
        const parts = data.operations.map((name, o) => ({ name, value: data.total.seconds[name], colour: weft.operationColour(o) }));
        const total = parts.reduce((s, p) => s + p.value, 0);
        holder.append(shareBar(parts, total), make("div", { class: "legend" }, parts.filter((p) => p.value > 0.0005 * total).map((p) => make("span", {}, make("i", { style: `background:${p.colour}` }), `${p.name} ${weft.percent(p.value / total)}`))));
      } else {
        const parts = report.stages.map((s, i) => ({ name: s.name, value: s.seconds, colour: weft.palette[i % weft.palette.length] }));
        const total = Math.max(1e-12, parts.reduce((s, p) => s + p.value, 0));
        holder.append(shareBar(parts, total), make("div", { class: "legend" }, parts.map((p) => make("span", {}, make("i", { style: `background:${p.colour}` }), `${p.name} ${weft.percent(p.value / total)}`))));
      }
    };
    draw();
    weft.onTheme.push(draw);
    return weft.card(data.total ? "Time of the workers during the adaptation" : "Time of the adaptation by stage", holder);
  }

  function build() {
    if (!report) return [simulation ? simulatedVerdict() : null, tiles(), data.total ? timeCard() : null];
    const warnings = report.warnings.length ? weft.card("Warnings", make("ul", {}, report.warnings.map((w) => make("li", {}, w)))) : null;
    return [verdict(), tiles(), report.left_as_is ? null : timeCard(), weft.publishedCard(), warnings];
  }

  weft.publishedCard = function publishedCard() {
    if (!data.published.length || !report) return null;
    const own = ["weft, this run", weft.count(data.total ? data.total.workers : report.threads), weft.digits(report.seconds.adapt), after.quality.mean.toFixed(3), after.quality["quantile_0.01"].toFixed(3), weft.digits(after.quality.min), weft.percent(after.edge_length.share_unit), { class: "text", text: "seconds of the adaptation" }];
    const rows = data.published.map((p) => [p.program, p.cores, weft.digits(p.seconds), p.quality_mean.toFixed(3), p["quality_quantile_0.01"].toFixed(3), weft.digits(p.quality_min), weft.percent(p.share_unit), { class: "text", text: p.source }]);
    return weft.card(`Published results for ${data.case}`, weft.table(["program", "cores", "seconds", "Q mean", "Q 1 %", "Q min", "unit edges", "source"], [own, ...rows], { classOf: (r) => (r === 0 ? "own" : null) }));
  };

  weft.views.push({ id: "summary", title: "Summary", build });
})();
