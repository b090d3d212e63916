// SPDX-License-Identifier: Apache-2.0
// The live part of the page: a table of fixed size, numbers as text, lines in the charts. The layout and all
// decisions are the server's.
(() => {
  const KEEP = 6000; // rows of live data, five minutes
  const POINTS = 400; // points per line at most: about one per pixel of a plot
  const DRAW_MS = 180; // charts are drawn at most so often, and less often on a slow computer
  const SHARE = 4; // of its time a page spends at most one part in so many on drawing
  const fp = {
    signals: [], rows: [], serial: 0, begun: 0, axis: "t", seconds: 60, charts: [], inCharge: false,
    ticks: 0, tickTimes: [], drawn: 0, pause: DRAW_MS,
  };
  window.fp = fp;
  window.addEventListener("popstate", () => window.location.reload()); // Back: the campaign before

  fp.start = (event, signals, rows, serial, begun) => {
    fp.signals = signals;
    fp.rows = rows;
    fp.serial = serial;
    fp.begun = begun;
    window.socket.off(event);
    window.socket.on(event, fp.tick);
  };

  // one message from the server: new rows, numbers of the ribbon, words of the chips
  fp.tick = (message) => {
    fp.ticks += 1;
    fp.tickTimes.push(performance.now());
    if (fp.tickTimes.length > 100) fp.tickTimes.shift();
    const fresh = message.rows.slice(Math.max(0, message.rows.length - (message.serial - fp.serial)));
    // another bus: its time begins anew
    if (message.begun !== fp.begun || message.serial < fp.serial) fp.rows = [];
    fp.serial = message.serial;
    fp.begun = message.begun;
    for (const row of fresh) fp.rows.push(row);
    if (fp.rows.length > KEEP * 1.2) fp.rows = fp.rows.slice(-KEEP);
    const last = fp.rows[fp.rows.length - 1];
    if (last && message.live) {
      fp.signals.forEach((s, i) => setText("key", s.key, format(last[i], s.digits)));
    } else {
      fp.signals.forEach((s) => setText("key", s.key, "–"));
    }
    for (const e of document.querySelectorAll("[data-word]"))
      if (!(e.dataset.word in message.words)) setText("word", e.dataset.word, "–");
    for (const [word, text] of Object.entries(message.words)) setText("word", word, text || "–");
    document.body.dataset.live = message.live ? "yes" : "no";
    if (fresh.length || message.redraw) fp.draw();
  };

  fp.rate = () => {
    const t = fp.tickTimes;
    return t.length > 1 ? (1000 * (t.length - 1)) / (t[t.length - 1] - t[0]) : 0;
  };

  const setText = (kind, name, text) => {
    for (const e of document.querySelectorAll(`[data-${kind}="${name}"]`)) {
      if (e.textContent !== text) {
        e.textContent = text;
        e.dataset.value = text;
      }
    }
  };

  const format = (value, digits) =>
    value === null || value === undefined ? "–" : value.toFixed(digits).replace("-", "−");

  fp.show = (axis, seconds) => {
    fp.axis = axis;
    fp.seconds = seconds;
    fp.draw(true);
  };

  // Chromium keeps for ever every text that a canvas outside the page has measured, and labels of live plots are
  // new texts all day: so characters are measured, once each
  const widths = {};
  const ruler = document.createElement("canvas").getContext("2d");
  const measureText = (text, font) => {
    const known = (widths[font] ??= {});
    let width = 0;
    for (const c of String(text ?? "")) {
      if (!(c in known)) {
        ruler.font = font || "12px sans-serif";
        known[c] = ruler.measureText(c).width;
      }
      width += known[c];
    }
    return { width };
  };

  fp.register = (id, panels) => {
    import("nicegui-echart").then(({ echarts }) => echarts.setPlatformAPI({ measureText }));
    fp.charts = fp.charts.filter((c) => c.id !== id);
    fp.charts.push({ id, panels });
    setTimeout(() => fp.draw(true), 300);
  };

  fp.draw = (now) => {
    const time = performance.now();
    if (!now && (time - fp.drawn < fp.pause || document.hidden)) return;
    const column = Object.fromEntries(fp.signals.map((s, i) => [s.key, i]));
    const xi = column[fp.axis];
    const ti = column.t;
    const last = fp.rows.length ? fp.rows[fp.rows.length - 1][ti] : 0;
    let first = fp.rows.length;
    while (first > 0 && fp.rows[first - 1][ti] > last - fp.seconds) first -= 1;
    const step = Math.max(1, Math.ceil((fp.rows.length - first) / POINTS));
    const shown = [];
    for (let i = first; i < fp.rows.length; i += step) shown.push(fp.rows[i]);
    for (const chart of fp.charts) {
      const element = window.getElement(chart.id);
      if (!element || !element.chart || !element.$el.offsetParent) continue;
      const series = [];
      for (const panel of chart.panels)
        for (const key of panel) series.push({ data: shown.map((r) => [r[xi], r[column[key]]]) });
      // the ends of a window that moves are odd numbers, others at every drawing: only round ones are written
      const ends = fp.axis !== "t" || last <= fp.seconds;
      const axisLabel = { showMinLabel: ends, showMaxLabel: ends };
      const range = fp.axis === "t" ? { min: Math.max(0, last - fp.seconds), max: Math.max(last, fp.seconds) } : { min: null, max: null };
      element.chart.setOption({ series, xAxis: chart.panels.map(() => ({ ...range, axisLabel })) }, { lazyUpdate: false });
    }
    fp.drawn = performance.now();
    fp.pause = Math.max(DRAW_MS, SHARE * (fp.drawn - time));
  };

  // what was zoomed outlives a redraw and a refresh, in this browser
  fp.keep = (id, key) => {
    const chart = window.getElement(id)?.chart;
    if (!chart) return void setTimeout(() => fp.keep(id, key), DRAW_MS);
    const begun = "kept" in chart;
    chart.kept = key;
    const shown = () => chart.getOption().dataZoom?.[0];
    const apply = () => {
      const [start, end] = JSON.parse(localStorage.getItem(chart.kept) ?? "[0, 100]");
      const now = shown();
      const off = now && Math.max(Math.abs(now.start - start), Math.abs(now.end - end));
      if (off > 0.01) chart.dispatchAction({ type: "dataZoom", start, end });
    };
    apply();
    if (begun) return;
    chart.on("datazoom", () => localStorage.setItem(chart.kept, JSON.stringify([shown().start, shown().end])));
    chart.on("finished", apply);
  };

  fp.charge = (mine) => {
    fp.inCharge = mine;
  };
  const clock = new Worker("/assets/beat.js");
  clock.onmessage = () => {
    if (fp.inCharge) window.emitEvent("beat");
  };
})();
