// SPDX-License-Identifier: Apache-2.0
// What is seen in a chart, as a file: its points within the axes as CSV, or its picture as PNG.
(() => {
  const COLUMNS = ["curve", "x_axis", "x", "y_axis", "y", "value"]; // value: of the cells of a map

  fp.png = (id) => {
    const chart = window.getElement(id).chart;
    const url = chart.getDataURL({ type: "png", pixelRatio: 2, backgroundColor: "#ffffff", excludeComponents: ["dataZoom"] });
    save(url, `${nameOf(id)}.png`);
  };

  fp.csv = (id) => {
    const lines = [COLUMNS, ...seen(window.getElement(id).chart)].map((row) => row.map(cell).join(","));
    const url = URL.createObjectURL(new Blob([`${lines.join("\r\n")}\r\n`], { type: "text/csv" }));
    save(url, `${nameOf(id)}.csv`);
    URL.revokeObjectURL(url);
  };

  const seen = (chart) => {
    const option = chart.getOption();
    const hidden = option.legend?.[0]?.selected ?? {};
    return option.series.filter((s) => hidden[s.name] !== false).flatMap((s) => pointsOf(chart, option, s));
  };

  const pointsOf = (chart, option, series) => {
    const at = [series.xAxisIndex ?? 0, series.yAxisIndex ?? 0];
    const axes = [option.xAxis[at[0]], option.yAxis[at[1]]];
    const live = [fp.signals.find((s) => s.key === fp.axis)?.name, option.title?.[at[1]]?.text];
    const names = axes.map((axis, k) => axis.name || live[k] || "");
    const ends = ["xAxis", "yAxis"].map((kind, k) => chart.getModel().getComponent(kind, at[k]).axis.scale.getExtent());
    const byName = axes.findIndex((axis) => axis.type === "category");
    const rows = [];
    (series.data ?? []).forEach((point, i) => {
      const value = point?.value ?? point;
      const pair = Array.isArray(value) ? value : byName === 0 ? [i, value] : [value, i];
      // whoever zooms chooses a part of the abscissa: a curve that leaves the chart above is still meant
      if (pair[0] < ends[0][0] || pair[0] > ends[0][1]) return;
      const [x, y] = axes.map((axis, k) => (axis.type === "category" ? (axis.data[pair[k]]?.value ?? axis.data[pair[k]]) : pair[k]));
      rows.push([series.name, names[0], x, names[1], y, pair[2]]);
    });
    return rows;
  };

  const cell = (value) => {
    const text = String(value ?? "");
    return /[",\r\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
  };

  const nameOf = (id) => {
    const element = document.getElementById(`c${id}`);
    const words = [window.getElement(id).chart.kept?.replace(/^zoom /, ""), element.closest(".fp-card").querySelector(".fp-head").textContent];
    return words.filter(Boolean).join(" ").replace(/[^\p{L}\p{N}.+-]+/gu, "_");
  };

  const save = (href, download) => {
    const link = Object.assign(document.createElement("a"), { href, download });
    document.body.append(link);
    link.click();
    link.remove();
  };
})();
