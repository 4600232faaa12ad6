// The tabs. A view is built when it is shown first.
"use strict";
(() => {
  const { make, data } = weft;
  const views = weft.views.filter((v) => !v.shown || v.shown());
  const content = document.getElementById("content"), tabs = document.getElementById("tabs");

  weft.show = function show(id) {
    for (const view of views) {
      const selected = view.id === id;
      view.tab.setAttribute("aria-selected", String(selected));
      view.tab.tabIndex = selected ? 0 : -1;
      if (selected && !view.section) {
        view.section = make("section", { id: "view-" + view.id, role: "tabpanel", "aria-labelledby": "tab-" + view.id });
        content.append(view.section);
        view.section.append(...view.build().filter((part) => part));
      }
      if (view.section) view.section.hidden = !selected;
      if (selected && view.onshow) requestAnimationFrame(view.onshow);
    }
    weft.tip(null, "");
    history.replaceState(null, "", "#" + id);
  };

  views.forEach((view, i) => {
    view.tab = make("button", { type: "button", role: "tab", id: "tab-" + view.id, "aria-controls": "view-" + view.id, title: `key: ${i + 1}`, onclick: () => weft.show(view.id) }, view.title);
    tabs.append(view.tab);
  });
  tabs.addEventListener("keydown", (event) => {
    const at = views.findIndex((v) => v.tab === document.activeElement);
    const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
    if (!step || at < 0) return;
    const next = views[(at + step + views.length) % views.length];
    weft.show(next.id);
    next.tab.focus();
  });
  addEventListener("keydown", (event) => {
    const n = Number(event.key);
    if (n >= 1 && n <= views.length && !event.ctrlKey && !event.altKey && !event.metaKey && !/INPUT|SELECT/.test(event.target.tagName)) weft.show(views[n - 1].id);
  });

  const words = data.report ? data.report.arguments : [], input = words.find((w) => /\.(meshb?|msh|vtu|pvtu|cgns|ugrid|su2)$/.test(w)) || "";
  const simulated = data.simulation && `${data.simulation.graph}, simulated on ${weft.plural(data.simulation.ranks, "rank")}`;
  document.getElementById("what").textContent = "· " + (simulated || data.case || input.split("/").pop() || "adaptation");
  document.title = "weft report " + document.getElementById("what").textContent;
  weft.startTheme();
  const linked = () => views.find((v) => v.id === location.hash.slice(1));
  weft.show(linked() ? linked().id : "summary");
  addEventListener("hashchange", () => linked() && weft.show(linked().id));
  document.documentElement.dataset.ready = "";
})();
