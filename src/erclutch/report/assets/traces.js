"use strict";
// Measured against estimated: plots that can be zoomed, with cursor, legend and the whole log as a strip.
function traces(T) {
  const box = $("traces-plot"), KNOTS = T.time, LAST = T.rows - 1;
  const channels = Object.fromEntries(Object.entries(T.channels).map(([name, body]) => [name, new Channel(body)]));
  const COLOURS = { recommended: "--recommended", best: "--best", baseline: "--baseline" };
  const DASHES = { recommended: [], best: [7, 4], baseline: [2, 3] };
  const models = new Map(T.models.map((m) => [m.name, m]));
  const first = ["recommended", "baseline", "best"];
  let chosen = T.models.filter((m) => m.role).sort((a, b) => first.indexOf(a.role) - first.indexOf(b.role)).map((m) => m.name).slice(0, 2);
  const spare = ["--other1", "--other2", "--other3"];
  const style = (name) => {
    const role = models.get(name).role;
    if (role) return [COLOURS[role], DASHES[role]];
    const k = chosen.filter((n) => !models.get(n).role).indexOf(name);
    return [spare[Math.max(k, 0) % spare.length], [10, 3, 2, 3]];
  };

  // Rows and time: straight lines between knots.
  const between = (x, from, to) => {
    let a = 0, b = KNOTS.length - 1;
    while (b - a > 1) {
      const middle = (a + b) >> 1;
      if (KNOTS[middle][from] <= x) a = middle;
      else b = middle;
    }
    const [p, q] = [KNOTS[a], KNOTS[Math.min(a + 1, KNOTS.length - 1)]];
    const width = q[from] - p[from];
    return width ? p[to] + ((x - p[from]) / width) * (q[to] - p[to]) : p[to];
  };
  const timeOf = (row) => between(row, 0, 1);
  const rowOf = (time) => Math.max(0, Math.min(LAST, between(time, 1, 0)));
  const held = (row) => T.test.some(([a, b]) => row >= a && row < b);

  let view = [...T.windows.typical], cursor = null, frame = null, drawn = null;
  const inputs = (kind) => T.inputs.filter((i) => i.kind === kind);

  // What is on screen: each step is two points, the smallest and the largest value of its rows.
  async function sample() {
    const [r0, r1] = view;
    const names = ["measured", ...chosen.flatMap((m) => [`estimate:${m}`, `residual:${m}`]), ...T.inputs.map((i) => i.channel)];
    await Promise.all(names.map((n) => channels[n].ready(r0, r1)).filter(Boolean));
    if (view[0] !== r0 || view[1] !== r1) return null;
    const most = Math.max(60, Math.floor(box.clientWidth * 0.9)), single = r1 - r0 <= 2 * most;
    const steps = single ? r1 - r0 : most;
    const edges = Array.from({ length: steps + 1 }, (_, k) => Math.round(r0 + ((r1 - r0) * k) / steps));
    const each = (range) => edges.slice(1).map((stop, k) => range(edges[k], stop));
    const breaks = T.breaks.filter((b) => b > r0 && b < r1);
    const x = [], at = [];
    for (let k = 0; k < steps; k++) {
      const [a, b] = [timeOf(edges[k]), timeOf(edges[k + 1] - 1)];
      if (k && breaks.some((row) => row > edges[k - 1] && row <= edges[k])) {
        x.push(a - 1e-9);
        at.push(null);
      }
      x.push(a, a + 0.5 * Math.max(b - a, 1e-9));
      at.push([k, 0], [k, 1]);
    }
    const layers = Object.fromEntries(names.map((name) => [name, channels[name].pick(r0, r1)]));
    const values = Object.fromEntries(names.map((name) => [name, each((a, b) => channels[name].range(layers[name], a, b))]));
    // Where both are there row by row, the residual follows from them to the last row.
    for (const m of chosen)
      if (layers.measured.bucket === 1 && layers[`estimate:${m}`].bucket === 1)
        values[`residual:${m}`] = each((a, b) => difference(layers, `estimate:${m}`, a, b));
    const series = (name, factor) => at.map((place) => place && factor * values[name][place[0]][place[1]]);
    return { r0, r1, x, edges, whole: single && layers.measured.bucket === 1, values, series };
  }

  function difference(layers, name, a, b) {
    const value = (of, row) => channels[of].value(layers[of].values[row - layers[of].start]);
    let low = Infinity, high = -Infinity;
    for (let row = a; row < b; row++) {
      const d = value("measured", row) - value(name, row);
      low = Math.min(low, d);
      high = Math.max(high, d);
    }
    return [low, high];
  }

  // --- plots
  const plots = [];
  const AXIS = 58;
  const marks = (u, splits, axis, space, step) => splits.map((v) => (v === null ? "" : digits(v, step)));
  const axes = (title, height) => {
    const font = "11px system-ui, sans-serif", colour = () => css("--mut");
    const grid = { stroke: () => css("--line"), width: 1 };
    return [
      { stroke: colour, font, grid: { show: false }, ticks: { stroke: () => css("--line"), size: 4 }, size: 26, values: marks },
      { stroke: colour, font, grid, ticks: { show: false }, size: AXIS, space: height < 130 ? 17 : 30, values: marks, label: title, labelSize: 14, labelFont: font, labelGap: 0 },
    ];
  };
  function tint(u) {
    const ctx = u.ctx, { left, top, width, height } = u.bbox;
    ctx.save();
    ctx.fillStyle = css("--held");
    for (const [a, b] of T.test) {
      const [x0, x1] = [timeOf(a), timeOf(b - 1)].map((t) => Math.max(left, Math.min(left + width, u.valToPos(t, "x", true))));
      if (x1 > x0) ctx.fillRect(x0, top, x1 - x0, height);
    }
    ctx.restore();
  }
  function plot(id, height, title, lines, last) {
    const options = {
      width: $(id).clientWidth, height: Math.max(height, 6 * title.length + (last ? 34 : 16)), padding: [6, 6, 0, 0], pxAlign: 1,
      scales: { x: { time: false }, y: { range: (u, low, high) => { const s = 0.06 * (high - low) || Math.abs(high) * 0.1 || 1; return [low - s, high + s]; } } },
      cursor: { sync: { key: "traces", setSeries: false }, drag: { x: true, y: false, setScale: false }, points: { size: 5 }, focus: { prox: -1 } },
      legend: { show: false },
      axes: axes(title, height),
      series: [{}, ...lines.map(([colour, dash, width]) => ({ stroke: () => css(colour), dash, width, spanGaps: false, points: { show: false } }))],
      hooks: {
        drawClear: [tint],
        setSelect: [(u) => {
          // The others follow this one's drag: they only let go of it.
          if (u !== dragged || u.select.width < 4) return void u.setSelect({ left: 0, width: 0, top: 0, height: 0 }, false);
          const [a, b] = [u.posToVal(u.select.left, "x"), u.posToVal(u.select.left + u.select.width, "x")];
          u.setSelect({ left: 0, width: 0, top: 0, height: 0 }, false);
          back.push([...view]);
          go(Math.floor(rowOf(a)), Math.ceil(rowOf(b)) + 1);
        }],
        setCursor: [(u) => { if (u.cursor.left >= 0 && drawn) point(u.posToVal(u.cursor.left, "x")); else if (u.cursor.left < 0) point(null); }],
      },
    };
    if (!last) options.axes[0].values = (u, s) => s.map(() => ""), (options.axes[0].size = 8);
    const made = new uPlot(options, [[0, 1], ...lines.map(() => [0, 0])], $(id));
    made.over.addEventListener("mousedown", () => (dragged = made), true);
    made.over.addEventListener("dblclick", () => { const to = back.pop(); if (to) go(...to); else named("typical"); });
    plots.push(made);
    return made;
  }
  const back = [];
  let dragged = null;
  let panels = [];
  function build() {
    for (const p of plots.splice(0)) p.destroy();
    $("readout").style.minHeight = "";
    const narrow = box.clientWidth < 560;
    const E = T.effort, unit = (u) => (u ? ` [${u}]` : "");
    // The first one is drawn last, over the others.
    const order = [...chosen].reverse(), shown = order.map((m) => [m, ...style(m)]);
    const input = (kind) => inputs(kind).map((i, k) => [["--measured", "--mut"][k], k ? [6, 3] : [], 1.2]);
    panels = [
      { u: plot("panel-effort", narrow ? 210 : 270, E.name + unit(E.unit), [["--measured", [], 1.4], ...shown.map(([, c, d]) => [c, d, 1.5])]), names: ["measured", ...order.map((m) => `estimate:${m}`)], factor: E.factor },
      { u: plot("panel-residual", narrow ? 100 : 120, "residual" + unit(E.unit), shown.map(([, c]) => [c, [], 1.1])), names: order.map((m) => `residual:${m}`), factor: E.factor },
    ];
    for (const kind of ["field", "slip"]) {
      const list = inputs(kind), last = kind === "slip";
      panels.push({ u: plot(`panel-${kind}`, last ? 108 : 84, kind + unit(list[0].unit), input(kind), last), names: list.map((i) => i.channel), factor: list[0].factor });
    }
  }

  async function render() {
    const made = await sample();
    if (!made) return;
    drawn = made;
    const span = [timeOf(made.r0), timeOf(made.r1 - 1)];
    for (const p of panels) {
      p.u.batch(() => {
        p.u.setData([made.x, ...p.names.map((n) => made.series(n, p.factor))], false);
        p.u.setScale("x", { min: span[0], max: span[1] });
      });
    }
    overview();
    readout(cursor);
    for (const b of box.querySelectorAll("[data-go]")) if (places[b.dataset.go]) b.setAttribute("aria-pressed", String(same(places[b.dataset.go]())));
    box.dataset.ready = "yes";
    box.dataset.rows = `${made.r0},${made.r1}`;
    box.dataset.whole = String(made.whole);
  }
  const later = () => { if (!frame) frame = requestAnimationFrame(() => { frame = null; render(); }); };

  // --- where to look
  const places = {
    typical: () => T.windows.typical,
    worst: () => T.windows.worst,
    test: () => [T.test[0][0], T.test[T.test.length - 1][1]],
    all: () => [0, T.rows],
  };
  const same = (rows) => rows[0] === view[0] && rows[1] === view[1];
  function go(r0, r1) {
    const width = Math.max(20, Math.min(T.rows, Math.round(r1 - r0)));
    const start = Math.max(0, Math.min(T.rows - width, Math.round(r0)));
    view = [start, start + width];
    later();
  }
  const named = (name) => go(...places[name]());
  const zoom = (factor, middle = (view[0] + view[1]) / 2) => {
    const width = (view[1] - view[0]) * factor, share = (middle - view[0]) / (view[1] - view[0]);
    go(middle - share * width, middle + (1 - share) * width);
  };
  const pan = (share) => { const d = share * (view[1] - view[0]); go(view[0] + d, view[1] + d); };
  const moves = { left: () => pan(-0.5), right: () => pan(0.5), in: () => zoom(0.5), out: () => zoom(2) };
  for (const button of box.querySelectorAll("[data-go]")) {
    const name = button.dataset.go;
    button.addEventListener("click", () => { back.push([...view]); places[name] ? named(name) : moves[name](); });
  }
  box.addEventListener("wheel", (event) => {
    if (!event.ctrlKey && !event.metaKey) return;
    event.preventDefault();
    const u = panels[0].u, x = event.clientX - u.over.getBoundingClientRect().left;
    zoom(event.deltaY > 0 ? 1.25 : 0.8, rowOf(u.posToVal(x, "x")));
  }, { passive: false });
  box.addEventListener("keydown", (event) => {
    if (event.target.tagName === "SELECT" || event.ctrlKey || event.metaKey || event.altKey) return;
    const step = (k) => {
      const row = Math.max(view[0], Math.min(view[1] - 1, (cursor ?? Math.round((view[0] + view[1]) / 2)) + k));
      const u = panels[0].u;
      u.setCursor({ left: u.valToPos(timeOf(row), "x"), top: 10 });
      point(timeOf(row));
      $("said").textContent = $("readout").innerText.replace(/\s+/g, " ");
    };
    const fine = Math.max(1, Math.round((view[1] - view[0]) / 200));
    const keys = { ArrowLeft: () => pan(-0.25), ArrowRight: () => pan(0.25), "+": () => zoom(0.5), "=": () => zoom(0.5), "-": () => zoom(2), Home: () => named("all"), End: () => named("test"), Escape: () => named("typical"), ",": () => step(-fine), ".": () => step(fine) };
    if (!keys[event.key]) return;
    event.preventDefault();
    keys[event.key]();
  });

  // --- cursor and legend in one line
  const point = (time) => { cursor = time === null ? null : Math.round(rowOf(time)); readout(cursor); };
  function readout(row) {
    if (!drawn) return;
    const E = T.effort, items = [];
    const k = row !== null && row >= drawn.r0 && row < drawn.r1 ? drawn.edges.slice(0, -1).findLastIndex((edge) => edge <= row) : -1;
    const show = (name, factor, unit) => {
      if (k < 0) return "";
      const [a, b] = drawn.values[name][k].map((v) => v * factor), step = channels[name].step * factor;
      return (a === b ? digits(a, step) : `${digits(a, step)} … ${digits(b, step)}`) + (unit ? ` ${unit}` : "");
    };
    const dash = (d) => (d.length ? (d[0] < 4 ? "dotted" : "dashed") : "solid");
    items.push(["measured", "--measured", "solid", show("measured", E.factor, E.unit), null]);
    for (const m of chosen) {
      const [colour, d] = style(m);
      const rest = show(`residual:${m}`, E.factor, "");
      items.push([models.get(m).title, colour, dash(d), show(`estimate:${m}`, E.factor, E.unit) + (rest ? `, off by ${rest}` : ""), chosen.length > 1 ? m : null]);
    }
    T.inputs.forEach((i) => {
      const n = inputs(i.kind).indexOf(i);
      if (k >= 0 || inputs(i.kind).length > 1) items.push([i.label, ["--measured", "--mut"][n], n ? "dashed" : "solid", show(i.channel, i.factor, i.unit), null]);
    });
    const out = $("readout");
    out.replaceChildren();
    const log = row === null ? null : T.logs.find(([, a, b]) => row >= a && row < b);
    if (k >= 0) out.append(element("span", "item", `${digits(timeOf(row), 1e-4)} s${held(row) ? ", held out" : ", training"}${T.logs.length > 1 && log ? `, ${log[0]}` : ""}`));
    for (const [name, colour, line, value, gone] of items) {
      const item = element("span", "item"), mark = element("i");
      mark.style.borderTopColor = css(colour);
      mark.style.borderTopStyle = line;
      item.append(mark, element("span", "", name));
      if (value) item.append(element("span", "value", value));
      if (gone && k < 0) {
        const b = element("button", "", "×");
        b.type = "button";
        b.setAttribute("aria-label", `Leave out ${models.get(gone).title}`);
        b.addEventListener("click", () => { chosen = chosen.filter((n) => n !== gone); select(); build(); later(); });
        item.append(b);
      }
      out.append(item);
    }
    // Lines of the readout may come with the pointer, but the plots must not move under it each time.
    if (k >= 0) out.style.minHeight = `${out.offsetHeight}px`;
    box.dataset.cursor = k >= 0 ? String(row) : "";
  }

  // --- models to add
  const list = $("add-model");
  function select() {
    list.replaceChildren(new Option(chosen.length >= 4 ? "four at most" : "…", ""));
    for (const m of T.models) if (!chosen.includes(m.name) && chosen.length < 4) list.append(new Option(m.title, m.name));
    list.disabled = list.options.length < 2;
  }
  list.addEventListener("change", () => {
    if (!list.value) return;
    chosen.push(list.value);
    select(); build(); later();
  });

  // --- the whole log as a strip
  const strip = $("overview");
  let margin = AXIS;
  function overview() {
    const ratio = devicePixelRatio || 1, width = strip.clientWidth, height = strip.clientHeight;
    margin = panels[0].u.over.offsetLeft;
    strip.width = width * ratio;
    strip.height = height * ratio;
    const ctx = strip.getContext("2d"), c = channels.measured, inner = width - margin - 6;
    ctx.scale(ratio, ratio);
    const x = (row) => margin + (row / T.rows) * inner;
    ctx.fillStyle = css("--held");
    for (const [a, b] of T.test) ctx.fillRect(x(a), 0, x(b) - x(a), height);
    const waiting = c.ready(0, T.rows), layer = c.pick(0, T.rows);
    if (waiting) return void waiting.then(overview);
    const n = Math.floor(inner), lows = [], highs = [];
    for (let k = 0; k < n; k++) {
      const a = Math.floor((k * T.rows) / n), [lo, hi] = c.range(layer, a, Math.max(a + 1, Math.floor(((k + 1) * T.rows) / n)));
      lows.push(lo); highs.push(hi);
    }
    const low = Math.min(...lows), scale = (height - 6) / (Math.max(...highs) - low || 1);
    ctx.fillStyle = css("--mut");
    for (let k = 0; k < n; k++) ctx.fillRect(margin + k, height - 3 - (highs[k] - low) * scale, 1, Math.max(1, (highs[k] - lows[k]) * scale));
    ctx.strokeStyle = css("--link");
    ctx.lineWidth = 2;
    ctx.strokeRect(x(view[0]), 1, Math.max(3, x(view[1]) - x(view[0])), height - 2);
  }
  let from = null;
  const rowAt = (event) => Math.max(0, Math.min(T.rows, ((event.clientX - strip.getBoundingClientRect().left - margin) / (strip.clientWidth - margin - 6)) * T.rows));
  strip.addEventListener("pointerdown", (event) => { from = rowAt(event); back.push([...view]); strip.setPointerCapture(event.pointerId); });
  strip.addEventListener("pointermove", (event) => { if (from === null) return; const to = rowAt(event); if (Math.abs(to - from) > T.rows / 200) go(Math.min(from, to), Math.max(from, to)); });
  strip.addEventListener("pointerup", (event) => {
    const to = rowAt(event), width = view[1] - view[0];
    if (from !== null && Math.abs(to - from) <= T.rows / 200) go(to - width / 2, to + width / 2);
    from = null;
  });

  select();
  build();
  render();
  redrawn.push(() => { for (const p of panels) p.u.redraw(false, true); overview(); readout(cursor); });
  let wide = box.clientWidth;
  addEventListener("resize", () => { if (box.clientWidth !== wide) { wide = box.clientWidth; build(); later(); } });
}

if (DATA.traces) {
  if (typeof DecompressionStream === "undefined") $("readout").textContent = "This browser is too old for this plot; all others are here.";
  else traces(DATA.traces);
}
