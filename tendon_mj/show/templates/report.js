"use strict";
(async () => {
  if (!("DecompressionStream" in window)) return; // the pictures stay
  const read = (id) => document.getElementById(id).textContent;
  const charts = JSON.parse(read("charts")), dark = JSON.parse(read("dark"));
  const packed = Uint8Array.from(atob(read("library").trim()), (c) => c.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
  const script = document.createElement("script");
  script.textContent = await new Response(stream).text();
  document.head.append(script);

  const theme = matchMedia("(prefers-color-scheme: dark)"), page = document.documentElement;
  const isDark = () => theme.matches && !page.classList.contains("printing");
  const inTheme = (value) => {
    if (typeof value === "string") return (isDark() && dark[value]) || value;
    if (Array.isArray(value)) return value.map(inTheme);
    if (value && typeof value === "object")
      return Object.fromEntries(Object.entries(value).map(([k, v]) => [k, inTheme(v)]));
    return value;
  };
  const style = (layout) => {
    const css = getComputedStyle(page);
    const colour = (name) => css.getPropertyValue(name).trim();
    const axis = { gridcolor: colour("--grid"), linecolor: colour("--line"), zerolinecolor: colour("--line") };
    const axes = Object.keys(layout).filter((key) => /^[xy]axis/.test(key));
    return {
      font: { color: colour("--ink"), size: 12, family: "system-ui, sans-serif" },
      paper_bgcolor: "rgba(0,0,0,0)", plot_bgcolor: "rgba(0,0,0,0)",
      margin: { l: 62, r: 12, t: 34, b: 46 },
      legend: { orientation: "h", x: 0, xanchor: "left", y: 1.02, yanchor: "bottom" },
      hoverlabel: { bgcolor: colour("--panel"), font: { color: colour("--ink") } },
      dragmode: matchMedia("(pointer: coarse)").matches ? false : "zoom", // a finger scrolls
      ...layout,
      ...(layout.title && { title: { ...layout.title, x: 0, xref: "paper", font: { size: 13 } } }),
      ...Object.fromEntries(axes.map((key) => [key, { ...axis, ...layout[key] }])),
    };
  };
  const draw = () => {
    for (const swatch of document.querySelectorAll(".legend i"))
      swatch.style.background = inTheme(swatch.dataset.colour);
    for (const figure of document.querySelectorAll("figure[data-charts]")) {
      const own = charts[figure.dataset.charts] || [];
      figure.classList.add("drawn");
      const places = figure.querySelectorAll(".plots > div");
      own.forEach((chart, k) => {
        Plotly.react(places[k], inTheme(chart.data), style(inTheme(chart.layout)),
          { responsive: true, displayModeBar: false });
      });
    }
  };
  draw();
  theme.addEventListener("change", draw);
  for (const [event, printing] of [["beforeprint", true], ["afterprint", false]])
    addEventListener(event, () => { page.classList.toggle("printing", printing); draw(); });
  page.dataset.ready = "charts";
})();
