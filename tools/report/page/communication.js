// Who sent how much to whom, or waited for whom, as a matrix of ranks.
"use strict";
(() => {
  const { data, make } = weft;

  function cells(what) {
    const list = [];
    if (what === "waiting") for (const w of data.waiting ? data.waiting.ranks : []) list.push([w.rank, w.for, w.seconds]);
    else data.messages.from.forEach((from, i) => list.push([from, data.messages.to[i], data.messages[what][i]]));
    return list;
  }
  const text = { bytes: weft.bytes, messages: weft.count, waiting: weft.seconds };

  function matrix() {
    const ranks = data.ranks.length, canvas = make("canvas", { class: "plot", role: "img", tabindex: 0, "aria-label": "Matrix of ranks" });
    let what = "bytes", dense = [], most = 0;
    const margin = 44, status = make("p", { class: "note", role: "status" });
    const geometry = () => {
      const width = Math.min(canvas.parentElement.clientWidth, 720, margin + 160 * ranks), size = (width - margin) / ranks;
      return { width, size };
    };
    function draw() {
      const { width, size } = geometry(), scale = devicePixelRatio || 1;
      canvas.style.width = canvas.style.height = width + "px";
      canvas.width = canvas.height = width * scale;
      const c = canvas.getContext("2d");
      c.scale(scale, scale);
      dense = new Float64Array(ranks * ranks);
      most = 0;
      let least = Infinity;
      for (const [from, to, value] of cells(what)) { dense[from * ranks + to] += value; }
      for (const v of dense) if (v > 0) { most = Math.max(most, v); least = Math.min(least, v); }
      const span = Math.log(most / least) || 1;
      for (let from = 0; from < ranks; ++from) for (let to = 0; to < ranks; ++to) {
        const v = dense[from * ranks + to];
        c.fillStyle = v > 0 ? `rgb(${weft.viridis(0.08 + 0.92 * Math.log(v / least) / span)})` : weft.css("--ground");
        c.fillRect(margin + to * size, margin + from * size, Math.max(1, size - (size > 6 ? 1 : 0)), Math.max(1, size - (size > 6 ? 1 : 0)));
        if (size > 46 && v > 0) {
          c.fillStyle = Math.log(v / least) / span > 0.6 ? "#111" : "#fff";
          c.font = "11px system-ui, sans-serif";
          c.fillText(text[what](v), margin + to * size + 4, margin + (from + 0.5) * size + 4);
        }
      }
      c.fillStyle = weft.css("--soft");
      c.font = "11px system-ui, sans-serif";
      const step = Math.max(1, Math.ceil((ranks > 100 ? 30 : 22) / size));
      for (let r = 0; r < ranks; r += step) {
        const at = margin + (r + 0.5) * size;
        c.textAlign = "center";
        c.fillText(r, at, margin - 6);
        c.textAlign = "right";
        c.fillText(r, margin - 6, at + 4);
      }
      c.textAlign = "left";
      c.fillText(what === "waiting" ? "waited for →" : "to rank →", margin, 14);
      c.save();
      c.translate(12, margin + 70);
      c.rotate(-Math.PI / 2);
      c.fillText(what === "waiting" ? "← rank" : "← from rank", 0, 0);
      c.restore();
      status.textContent = `Colours from ${text[what](least === Infinity ? 0 : least)} (dark) to ${text[what](most)} (bright), logarithmic; empty: none.`;
    }
    canvas.addEventListener("mousemove", (event) => {
      const { size } = geometry(), box = canvas.getBoundingClientRect();
      const to = Math.floor((event.clientX - box.left - margin) / size), from = Math.floor((event.clientY - box.top - margin) / size);
      const inside = to >= 0 && from >= 0 && to < ranks && from < ranks;
      weft.tip(event, inside ? (what === "waiting" ? `rank ${from} waited for rank ${to}: ` : `rank ${from} to rank ${to}: `) + text[what](dense[from * ranks + to]) : "");
    });
    canvas.addEventListener("mouseleave", (event) => weft.tip(event, ""));
    weft.onTheme.push(() => canvas.isConnected && canvas.parentElement.clientWidth && draw());
    addEventListener("resize", () => canvas.parentElement.clientWidth && draw());
    const choices = [["bytes", "Bytes"], ["messages", "Messages"]];
    if (data.waiting) choices.push(["waiting", "Waiting"]);
    const card = weft.card("From rank to rank", make("div", { class: "tool" }, weft.choice("what", choices, (w) => { what = w; draw(); })), make("div", {}, canvas), status);
    requestAnimationFrame(draw);
    return card;
  }

  const meanings = { invoke: "values and calls for subdomains", signal: "arrivals for events", migrate: "subdomains that migrated to another rank", forward: "forwarded because the subdomain had migrated" };

  function volumes() {
    const kinds = Object.entries(data.engine.traffic).map(([kind, v]) => [kind, { class: "text", text: meanings[kind] || "" }, weft.count(v.sent.messages), weft.bytes(v.sent.bytes), weft.count(v.received.messages), weft.bytes(v.received.bytes)]);
    const figures = Object.keys(data.engine.traffic).map((kind) => ["", "", `traffic.${kind}.messages`, "", "", ""]);
    const same = data.engine.consistent, whole = same.messages && same.bytes && same.pairs;
    const methods = data.engine.methods.filter((m) => m.sent.messages > 0).sort((a, b) => b.sent.bytes - a.sent.bytes).map((m) => [m.name || "(engine)", weft.count(m.sent.messages), weft.bytes(m.sent.bytes)]);
    return [weft.card("By kind", weft.table(["kind", "purpose", "messages sent", "bytes sent", "messages received", "bytes received"], kinds, { figures }),
      make("p", { class: whole ? "note" : "worse" }, whole ? "Between each two ranks, messages and bytes received equal those sent." : "Some messages sent were not received: the record is incomplete.")),
    methods.length ? weft.card("By method", weft.table(["method", "messages", "bytes"], methods)) : null];
  }

  weft.views.push({ id: "communication", title: "Communication", shown: () => data.engine !== null, build: () => (data.ranks.length === 1 ? [weft.card("From rank to rank", weft.empty("One rank: no messages were sent; subdomains exchanged values in memory. Waiting is shown under Time."))] : [make("div", { class: "two" }, matrix(), make("div", {}, volumes()))]) });
})();
