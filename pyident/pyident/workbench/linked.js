// The framework fits a figure to its place once more when it has left the page, which Plotly refuses.
addEventListener("unhandledrejection", (event) => {
  if (String(event.reason?.message ?? event.reason).startsWith("Resize must be passed")) event.preventDefault();
});

// Figures of one page that show the same samples: what is brushed in one is marked in all.
// when(ids, call): call with the elements once all are there and their figures drawn.
function flexidentWhen(ids, call, tries = 300) {
  const elements = ids.map((id) => getHtmlElement(id));
  if (elements.every((e) => e && (e.role !== "figure" || (e.on && e._fullLayout)))) call(...elements);
  else if (tries) setTimeout(() => flexidentWhen(ids, call, tries - 1), 50);
}

// states: scatters over the same samples, the last of them over time; traces: its last curve shows the marks.
function flexidentBrush(states, traces, words) {
  import("nicegui-plotly").then(({ Plotly }) => {
    const scatters = () => states.data.map((t, i) => [t, i]).filter(([t]) => t.mode === "markers");
    const mark = (rows) => {
      const listed = scatters(), over = listed[listed.length - 1][0];
      const kept = rows ?? [];
      Plotly.restyle(states, { selectedpoints: listed.map(() => rows) }, listed.map(([, i]) => i));
      const x = kept.map((i) => over.x[i]), y = kept.map((i) => over.y[i]);
      Plotly.restyle(traces, { x: [x], y: [y] }, [traces.data.length - 1]);
      words.textContent = rows ? `${kept.length} of ${over.x.length} samples are marked in every panel` : "";
    };
    states.on("plotly_selected", (e) => {
      if (!e) return;
      const at = new Set(e.points.filter((p) => p.data.mode === "markers").map((p) => p.pointIndex));
      mark([...at].sort((a, b) => a - b));
    });
    states.on("plotly_deselect", () => mark(null));
  });
}
