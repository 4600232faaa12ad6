// What all views use: the data, elements, numbers as text, colours, charts, the theme.
"use strict";
/** The document: JSON, made small by gzip, as base64. */
async function readData() {
  const packed = Uint8Array.from(atob(document.getElementById("data").textContent), (c) => c.charCodeAt(0));
  return new Response(new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"))).json();
}
if (!globalThis.DecompressionStream) document.getElementById("content").textContent = "This browser is too old for this page: it needs one of 2023 or later.";
const weft = { views: [], data: await readData() };
globalThis.weft = weft;  // for the console

/** An element: tag, attributes ("on..." are listeners), children (nodes or text). */
weft.make = function make(tag, attributes = {}, ...children) {
  const svg = ["svg", "g", "rect", "path", "text", "circle", "line", "title", "defs", "marker"].includes(tag);
  const element = svg ? document.createElementNS("http://www.w3.org/2000/svg", tag) : document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith("on")) element.addEventListener(name.slice(2), value);
    else if (value === true) element.setAttribute(name, "");
    else if (value !== false && value !== null && value !== undefined) element.setAttribute(name, value);
  }
  for (const child of children.flat(9)) if (child !== null && child !== undefined) element.append(child);
  return element;
};

// --- Numbers

weft.count = (n) => Math.round(n).toLocaleString("en-US");
weft.digits = function digits(x, n = 3) {
  if (x === null || x === undefined || !isFinite(x)) return "–";
  if (x !== 0 && Math.abs(x) < 1e-4) return x.toExponential(1);
  return Number(x.toPrecision(n)).toLocaleString("en-US", { maximumFractionDigits: 8 });
};
weft.percent = (share, decimals = 1) => (share === null || share === undefined ? "–" : (100 * share).toFixed(decimals) + " %");
weft.seconds = function seconds(s) {
  if (s === null || s === undefined) return "–";
  const whole = Math.round(s);
  if (s >= 120) return Math.floor(whole / 60) + " min " + String(whole % 60).padStart(2, "0") + " s";
  if (s >= 0.1 || s < 5e-9) return weft.digits(s < 5e-9 ? 0 : s) + " s";
  return s >= 1e-4 ? weft.digits(1e3 * s) + " ms" : weft.digits(1e6 * s) + " µs";
};
weft.bytes = function bytes(b) {
  if (!b) return "0 B";
  const units = ["B", "kB", "MB", "GB", "TB"];
  const k = Math.min(4, Math.floor(Math.log10(Math.max(1, b)) / 3));
  return weft.digits(b / 10 ** (3 * k)) + " " + units[k];
};
weft.plural = (n, word) => weft.count(n) + " " + word + (n === 1 ? "" : "s");

// --- Colours

weft.palette = ["#2f6fb0", "#e07b16", "#2f9e77", "#b0529c", "#7aa52b", "#2aa3bd", "#c4a000", "#8d6e63", "#8795a5", "#9cc3ea"];
weft.operationColour = (o) => (weft.data.operations[o] === "idle" ? weft.css("--idle") : weft.palette[o % weft.palette.length]);
weft.css = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
/** Viridis (Smith and van der Walt, 2015), from eight of its colours. */
weft.viridis = function viridis(t) {
  const stops = [[68, 1, 84], [70, 50, 127], [54, 92, 141], [39, 127, 142], [31, 161, 135], [74, 194, 109], [159, 218, 58], [253, 231, 37]];
  const at = Math.max(0, Math.min(1, t)) * 7, i = Math.min(6, Math.floor(at)), f = at - i;
  return stops[i].map((c, k) => Math.round(c + f * (stops[i + 1][k] - c)));
};
/** Well apart for neighbours in a list of any length. */
weft.categoryColour = function categoryColour(i) {
  const hue = (i * 0.61803398875) % 1, light = 0.45 + 0.2 * ((i * 0.754877666) % 1);
  const channel = (n) => {
    const k = (n + hue * 12) % 12;
    return Math.round(255 * (light - 0.55 * Math.min(light, 1 - light) * Math.max(-1, Math.min(k - 3, 9 - k, 1))));
  };
  return [channel(0), channel(8), channel(4)];
};

// --- Parts of views

/** A table; `figures`, if given, names each cell of the rows for who checks the page: figures[row][column]. */
weft.table = function table(head, rows, options = {}) {
  const body = rows.map((row, r) =>
    weft.make("tr", { class: options.classOf ? options.classOf(r) : null },
      row.map((cell, c) => weft.make("td", { class: typeof cell === "object" && !(cell instanceof Node) ? cell.class : null, "data-figure": options.figures && options.figures[r][c] },
        typeof cell === "object" && !(cell instanceof Node) ? cell.text : cell))));
  const element = weft.make("table", {}, weft.make("thead", {}, weft.make("tr", {}, head.map((h) => weft.make("th", { scope: "col", class: h === "source" || h === "what for" ? "text" : null }, h)))),
    weft.make("tbody", {}, body));
  return weft.make("div", { class: "scroll" }, element);
};
weft.card = (title, ...children) => weft.make("div", { class: "card" }, title ? weft.make("h2", {}, title) : null, ...children);
weft.empty = (text) => weft.make("div", { class: "empty" }, text);
weft.legend = (operations) => weft.make("div", { class: "legend" }, operations.map((o) =>
  weft.make("span", {}, weft.make("i", { style: `background:${weft.operationColour(o)}` }), weft.data.operations[o])));

/** Buttons of which one is pressed; calls `chosen` with its value. */
weft.choice = function choice(label, values, chosen) {
  const buttons = values.map(([value, text], i) => weft.make("button", { type: "button", "aria-pressed": String(i === 0), "data-choice": value, onclick: () => {
    buttons.forEach((b, k) => b.setAttribute("aria-pressed", String(k === i)));
    chosen(value);
  } }, text));
  return weft.make("span", { role: "group", "aria-label": label, class: "tool", style: "margin:0" }, buttons);
};

const tip = document.getElementById("tip");
weft.tip = function showTip(event, text) {
  tip.hidden = !text;
  if (!text) return;
  tip.textContent = text;
  const box = tip.getBoundingClientRect();
  tip.style.left = Math.min(event.clientX + 14, innerWidth - box.width - 8) + "px";
  tip.style.top = (event.clientY + 18 + box.height > innerHeight ? event.clientY - box.height - 10 : event.clientY + 18) + "px";
};

// --- Charts

/** Round ticks of a logarithmic axis; Chart.js takes any digit, and its labels run into each other. */
weft.logarithmicTicks = function logarithmicTicks(axis) {
  const digits = Math.log10(axis.max / axis.min) > 3.5 ? [1] : [1, 2, 5];
  axis.ticks = [];
  for (let power = Math.floor(Math.log10(axis.min)); power <= Math.log10(axis.max); ++power)
    for (const digit of digits) {
      const value = Number(`${digit}e${power}`);
      if (value >= axis.min && value <= axis.max) axis.ticks.push({ value });
    }
};

weft.charts = [];
/** A Chart.js chart whose colours follow the theme: `configure` is called again when that changes. */
weft.chart = function chart(configure, height = 320, label = "") {
  const canvas = weft.make("canvas", { role: "img", "aria-label": label });
  const holder = weft.make("div", { class: "chart", style: `height:${height}px` }, canvas);
  const entry = { canvas, configure, chart: null };
  entry.draw = () => {
    if (entry.chart) entry.chart.destroy();
    Chart.defaults.color = weft.css("--soft");
    Chart.defaults.borderColor = weft.css("--line");
    Chart.defaults.animation = false;
    Chart.defaults.maintainAspectRatio = false;
    entry.chart = new Chart(canvas, configure());
  };
  weft.charts.push(entry);
  holder.redraw = entry.draw;
  requestAnimationFrame(entry.draw);
  return holder;
};

// --- The theme

weft.onTheme = [];
weft.setTheme = function setTheme(dark) {
  document.documentElement.dataset.theme = dark ? "dark" : "light";
  const button = document.getElementById("theme");
  button.textContent = dark ? "Light" : "Dark";
  button.setAttribute("aria-pressed", String(dark));
  weft.charts.forEach((entry) => entry.draw());
  weft.onTheme.forEach((f) => f());
};
weft.startTheme = function startTheme() {
  const wish = matchMedia("(prefers-color-scheme: dark)");
  const toggle = () => weft.setTheme(document.documentElement.dataset.theme !== "dark");
  weft.setTheme(wish.matches);
  wish.addEventListener("change", () => weft.setTheme(wish.matches));
  document.getElementById("theme").addEventListener("click", toggle);
  addEventListener("keydown", (event) => {
    if (event.key === "d" && !event.ctrlKey && !event.metaKey && !/INPUT|SELECT/.test(event.target.tagName)) toggle();
  });
};
