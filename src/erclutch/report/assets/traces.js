"use strict";
// Measured against estimated: plots that can be zoomed, with cursor, legend and the whole log as a strip.
//
// Three values say what is on screen: the rows in view, the chosen models, and the row under the cursor. Whoever changes
// one asks for a new drawing. `sample` then takes as much of the rows as the width can show, and each plot draws it.

const AXIS = 58; // pixels of the vertical axis, and left of the strip
const MARGIN = 6; // pixels right of the plots
const MOST_MODELS = 4;
const FEWEST_ROWS = 20; // in view
const COLOURS = { recommended: "--recommended", best: "--best", baseline: "--baseline" };
const DASHES = { recommended: [], best: [7, 4], baseline: [2, 3] };
const OTHERS = ["--other1", "--other2", "--other3"];
const INPUT_COLOURS = ["--measured", "--mut"]; // of both clutches of a pair
const FONT = "11px system-ui, sans-serif";

const between = (low, value, high) => Math.max(low, Math.min(high, value));
const inBrackets = (unit) => (unit ? ` [${unit}]` : "");

/** Rows and time of the log: straight lines between knots [row, s]. */
class LogClock {
  constructor(knots, rows) {
    this.knots = knots;
    this.last = rows - 1;
  }
  timeOf(row) { return this.along(row, 0, 1); }
  rowOf(time) { return between(0, this.along(time, 1, 0), this.last); }
  along(value, from, to) {
    const [before, after] = this.around(value, from);
    const width = after[from] - before[from];
    if (!width) return before[to];
    return before[to] + ((value - before[from]) / width) * (after[to] - before[to]);
  }
  around(value, from) {
    let low = 0;
    let high = this.knots.length - 1;
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (this.knots[middle][from] <= value) low = middle;
      else high = middle;
    }
    return [this.knots[low], this.knots[Math.min(low + 1, this.knots.length - 1)]];
  }
}

class Traces {
  /** T: what `traces_section.py` says of the log, its models and its channels. */
  constructor(T) {
    this.T = T;
    this.box = $("traces-plot");
    this.strip = $("overview");
    this.list = $("add-model");
    this.clock = new LogClock(T.time, T.rows);
    this.channels = Object.fromEntries(Object.entries(T.channels).map(([name, body]) => [name, new Channel(body)]));
    this.models = new Map(T.models.map((model) => [model.name, model]));
    this.places = {
      typical: () => T.windows.typical,
      worst: () => T.windows.worst,
      test: () => [T.test[0][0], T.test[T.test.length - 1][1]],
      all: () => [0, T.rows],
    };

    this.view = [...T.windows.typical]; // rows [first, stop)
    this.chosen = this.modelsAtFirst();
    this.cursor = null; // a row
    this.back = []; // earlier views
    this.drawn = null; // what `sample` last gave
    this.panels = [];
    this.frame = null; // asked for, not yet drawn
    this.dragged = null; // the plot in which the mouse went down
    this.margin = AXIS;

    this.listenToButtons();
    this.listenToWheel();
    this.listenToKeys();
    this.listenToList();
    this.listenToStrip();
    this.listenToPage();
    this.offerModels();
    this.build();
    this.render();
  }

  // --- models

  /** Two of the models that have a role. */
  modelsAtFirst() {
    const order = ["recommended", "baseline", "best"];
    const named = this.T.models.filter((model) => model.role);
    named.sort((a, b) => order.indexOf(a.role) - order.indexOf(b.role));
    return named.map((model) => model.name).slice(0, 2);
  }

  /** Colour and dashes of a chosen model. */
  style(name) {
    const { role } = this.models.get(name);
    if (role) return [COLOURS[role], DASHES[role]];
    const withoutRole = this.chosen.filter((other) => !this.models.get(other).role);
    const place = Math.max(withoutRole.indexOf(name), 0);
    return [OTHERS[place % OTHERS.length], [10, 3, 2, 3]];
  }

  offerModels() {
    const full = this.chosen.length >= MOST_MODELS;
    this.list.replaceChildren(new Option(full ? "four at most" : "…", ""));
    for (const model of this.T.models)
      if (!full && !this.chosen.includes(model.name)) this.list.append(new Option(model.title, model.name));
    this.list.disabled = this.list.options.length < 2;
  }

  choose(names) {
    this.chosen = names;
    this.offerModels();
    this.build();
    this.later();
  }

  listenToList() {
    this.list.addEventListener("change", () => {
      if (this.list.value) this.choose([...this.chosen, this.list.value]);
    });
  }

  // --- what is on screen: each step is two points, the smallest and the largest value of its rows

  /** What the rows in view look like at this width; null where the view has moved on meanwhile. */
  async sample() {
    const [first, stop] = this.view;
    const ofModels = this.chosen.flatMap((model) => [`estimate:${model}`, `residual:${model}`]);
    const names = ["measured", ...ofModels, ...this.T.inputs.map((input) => input.channel)];
    await Promise.all(names.map((name) => this.channels[name].ready(first, stop)).filter(Boolean));
    if (this.view[0] !== first || this.view[1] !== stop) return null;

    const most = Math.max(60, Math.floor(this.box.clientWidth * 0.9));
    const single = stop - first <= 2 * most; // each row is a step
    const steps = single ? stop - first : most;
    const edges = Array.from({ length: steps + 1 }, (_, k) => Math.round(first + ((stop - first) * k) / steps));
    const { times, places } = this.points(edges);
    const layers = Object.fromEntries(names.map((name) => [name, this.channels[name].pick(first, stop)]));
    const values = this.valuesOfSteps(names, layers, edges);
    const series = (name, factor) => places.map((place) => place && factor * values[name][place.step][place.end]);
    return { first, stop, times, edges, whole: single && layers.measured.bucket === 1, values, series };
  }

  /** Time of each point, and the step and end that it shows; null is a gap, at which lines break. */
  points(edges) {
    const breaks = this.T.breaks.filter((row) => row > edges[0] && row < edges[edges.length - 1]);
    const times = [];
    const places = [];
    for (let step = 0; step < edges.length - 1; step++) {
      const begin = this.clock.timeOf(edges[step]);
      const end = this.clock.timeOf(edges[step + 1] - 1);
      if (step && breaks.some((row) => row > edges[step - 1] && row <= edges[step])) {
        times.push(begin - 1e-9);
        places.push(null);
      }
      times.push(begin, begin + 0.5 * Math.max(end - begin, 1e-9));
      places.push({ step, end: 0 }, { step, end: 1 });
    }
    return { times, places };
  }

  /** Smallest and largest value of each step, by channel. */
  valuesOfSteps(names, layers, edges) {
    const each = (range) => edges.slice(1).map((stop, step) => range(edges[step], stop));
    const values = {};
    for (const name of names) values[name] = each((a, b) => this.channels[name].range(layers[name], a, b));
    // Where both are there row by row, the residual follows from them to the last row.
    for (const model of this.chosen) {
      const estimate = `estimate:${model}`;
      if (layers.measured.bucket === 1 && layers[estimate].bucket === 1)
        values[`residual:${model}`] = each((a, b) => this.difference(layers, estimate, a, b));
    }
    return values;
  }

  /** Smallest and largest of measured less estimated over rows [first, stop). */
  difference(layers, estimate, first, stop) {
    const value = (name, row) => this.channels[name].value(layers[name].values[row - layers[name].start]);
    let low = Infinity;
    let high = -Infinity;
    for (let row = first; row < stop; row++) {
      const residual = value("measured", row) - value(estimate, row);
      low = Math.min(low, residual);
      high = Math.max(high, residual);
    }
    return [low, high];
  }

  // --- plots

  /** New plots for the chosen models and this width: effort, residual, field, slip. */
  build() {
    for (const panel of this.panels.splice(0)) panel.plot.destroy();
    $("readout").style.minHeight = "";
    const narrow = this.box.clientWidth < 560;
    const { effort } = this.T;
    const order = [...this.chosen].reverse(); // the first model is drawn last, over the others
    const styles = order.map((model) => this.style(model));

    this.panels.push({
      plot: this.plot("panel-effort", narrow ? 210 : 270, effort.name + inBrackets(effort.unit), [
        ["--measured", [], 1.4],
        ...styles.map(([colour, dash]) => [colour, dash, 1.5]),
      ]),
      names: ["measured", ...order.map((model) => `estimate:${model}`)],
      factor: effort.factor,
    });
    this.panels.push({
      plot: this.plot("panel-residual", narrow ? 100 : 120, "residual" + inBrackets(effort.unit), styles.map(([colour]) => [colour, [], 1.1])),
      names: order.map((model) => `residual:${model}`),
      factor: effort.factor,
    });
    for (const kind of ["field", "slip"]) {
      const inputs = this.inputs(kind);
      const last = kind === "slip";
      const lines = inputs.map((_, place) => [INPUT_COLOURS[place], place ? [6, 3] : [], 1.2]);
      this.panels.push({
        plot: this.plot(`panel-${kind}`, last ? 108 : 84, kind + inBrackets(inputs[0].unit), lines, last),
        names: inputs.map((input) => input.channel),
        factor: inputs[0].factor,
      });
    }
  }

  inputs(kind) { return this.T.inputs.filter((input) => input.kind === kind); }

  /** One plot; lines are [colour, dash, width]. Only the last one names the time. */
  plot(id, height, title, lines, last = false) {
    const series = lines.map(([colour, dash, width]) => ({ stroke: () => css(colour), dash, width, spanGaps: false, points: { show: false } }));
    const options = {
      width: $(id).clientWidth,
      height: Math.max(height, 6 * title.length + (last ? 34 : 16)),
      padding: [6, MARGIN, 0, 0],
      pxAlign: 1,
      scales: { x: { time: false }, y: { range: (_, low, high) => this.widened(low, high) } },
      cursor: { sync: { key: "traces", setSeries: false }, drag: { x: true, y: false, setScale: false }, points: { size: 5 }, focus: { prox: -1 } },
      legend: { show: false },
      axes: this.axes(title, height),
      series: [{}, ...series],
      hooks: {
        drawClear: [(plot) => this.tint(plot)],
        setSelect: [(plot) => this.selected(plot)],
        setCursor: [(plot) => this.pointed(plot)],
      },
    };
    if (!last) {
      options.axes[0].values = (_, splits) => splits.map(() => "");
      options.axes[0].size = 8;
    }
    const made = new uPlot(options, [[0, 1], ...lines.map(() => [0, 0])], $(id));
    made.over.addEventListener("mousedown", () => { this.dragged = made; }, true);
    made.over.addEventListener("dblclick", () => this.goBack());
    return made;
  }

  widened(low, high) {
    const slack = 0.06 * (high - low) || Math.abs(high) * 0.1 || 1;
    return [low - slack, high + slack];
  }

  axes(title, height) {
    const stroke = () => css("--mut");
    const line = () => css("--line");
    const values = (_, splits, axis, space, step) => splits.map((value) => (value === null ? "" : digits(value, step)));
    return [
      { stroke, font: FONT, grid: { show: false }, ticks: { stroke: line, size: 4 }, size: 26, values },
      {
        stroke, font: FONT, grid: { stroke: line, width: 1 }, ticks: { show: false }, size: AXIS, space: height < 130 ? 17 : 30, values,
        label: title, labelSize: 14, labelFont: FONT, labelGap: 0,
      },
    ];
  }

  /** Rows that were held out have a ground of their own. */
  tint(plot) {
    const { left, top, width, height } = plot.bbox;
    const across = (row) => between(left, plot.valToPos(this.clock.timeOf(row), "x", true), left + width);
    plot.ctx.save();
    plot.ctx.fillStyle = css("--held");
    for (const [first, stop] of this.T.test) {
      const begin = across(first);
      const end = across(stop - 1);
      if (end > begin) plot.ctx.fillRect(begin, top, end - begin, height);
    }
    plot.ctx.restore();
  }

  /** A drag has ended: its times come into view. The other plots follow this one's drag, and only let go of it. */
  selected(plot) {
    const { left, width } = plot.select;
    const own = plot === this.dragged && width >= 4;
    const [begin, end] = [plot.posToVal(left, "x"), plot.posToVal(left + width, "x")];
    plot.setSelect({ left: 0, width: 0, top: 0, height: 0 }, false);
    if (!own) return;
    this.remember();
    this.go(Math.floor(this.clock.rowOf(begin)), Math.ceil(this.clock.rowOf(end)) + 1);
  }

  pointed(plot) {
    if (plot.cursor.left < 0) this.point(null);
    else if (plot.cursor.left >= 0 && this.drawn) this.point(plot.posToVal(plot.cursor.left, "x"));
  }

  async render() {
    const sampled = await this.sample();
    if (!sampled) return;
    this.drawn = sampled;
    const { first, stop, times, whole, series } = sampled;
    const ends = { min: this.clock.timeOf(first), max: this.clock.timeOf(stop - 1) };
    for (const { plot, names, factor } of this.panels)
      plot.batch(() => {
        plot.setData([times, ...names.map((name) => series(name, factor))], false);
        plot.setScale("x", ends);
      });
    this.drawStrip();
    this.readOut(this.cursor);
    for (const button of this.box.querySelectorAll("[data-go]")) {
      const place = this.places[button.dataset.go];
      if (place) button.setAttribute("aria-pressed", String(this.isInView(place())));
    }
    this.box.dataset.ready = "yes";
    this.box.dataset.rows = `${first},${stop}`;
    this.box.dataset.whole = String(whole);
  }

  /** Draws before the next picture of the screen, once for all that asked. */
  later() {
    this.frame ??= requestAnimationFrame(() => {
      this.frame = null;
      this.render();
    });
  }

  // --- where to look

  isInView([first, stop]) { return first === this.view[0] && stop === this.view[1]; }

  go(first, stop) {
    const { rows } = this.T;
    const width = between(FEWEST_ROWS, Math.round(stop - first), rows);
    const start = between(0, Math.round(first), rows - width);
    this.view = [start, start + width];
    this.later();
  }

  goTo(place) { this.go(...this.places[place]()); }

  remember() { this.back.push([...this.view]); }

  goBack() {
    const earlier = this.back.pop();
    if (earlier) this.go(...earlier);
    else this.goTo("typical");
  }

  zoom(factor, middle = (this.view[0] + this.view[1]) / 2) {
    const [first, stop] = this.view;
    const width = (stop - first) * factor;
    const share = (middle - first) / (stop - first);
    this.go(middle - share * width, middle + (1 - share) * width);
  }

  pan(share) {
    const [first, stop] = this.view;
    const rows = share * (stop - first);
    this.go(first + rows, stop + rows);
  }

  listenToButtons() {
    const moves = { left: () => this.pan(-0.5), right: () => this.pan(0.5), in: () => this.zoom(0.5), out: () => this.zoom(2) };
    for (const button of this.box.querySelectorAll("[data-go]")) {
      const name = button.dataset.go;
      button.addEventListener("click", () => {
        this.remember();
        if (this.places[name]) this.goTo(name);
        else moves[name]();
      });
    }
  }

  listenToWheel() {
    const turned = (event) => {
      if (!event.ctrlKey && !event.metaKey) return;
      event.preventDefault();
      const { plot } = this.panels[0];
      const x = event.clientX - plot.over.getBoundingClientRect().left;
      this.zoom(event.deltaY > 0 ? 1.25 : 0.8, this.clock.rowOf(plot.posToVal(x, "x")));
    };
    this.box.addEventListener("wheel", turned, { passive: false });
  }

  listenToKeys() {
    const fine = () => Math.max(1, Math.round((this.view[1] - this.view[0]) / 200));
    const keys = {
      ArrowLeft: () => this.pan(-0.25),
      ArrowRight: () => this.pan(0.25),
      "+": () => this.zoom(0.5),
      "=": () => this.zoom(0.5),
      "-": () => this.zoom(2),
      Home: () => this.goTo("all"),
      End: () => this.goTo("test"),
      Escape: () => this.goTo("typical"),
      ",": () => this.step(-fine()),
      ".": () => this.step(fine()),
    };
    this.box.addEventListener("keydown", (event) => {
      if (event.target.tagName === "SELECT" || event.ctrlKey || event.metaKey || event.altKey) return;
      if (!keys[event.key]) return;
      event.preventDefault();
      keys[event.key]();
    });
  }

  listenToPage() {
    redrawn.push(() => {
      for (const { plot } of this.panels) plot.redraw(false, true);
      this.drawStrip();
      this.readOut(this.cursor);
    });
    let width = this.box.clientWidth;
    addEventListener("resize", () => {
      if (this.box.clientWidth === width) return;
      width = this.box.clientWidth;
      this.build();
      this.later();
    });
  }

  // --- cursor and legend in one line

  point(time) {
    this.cursor = time === null ? null : Math.round(this.clock.rowOf(time));
    this.readOut(this.cursor);
  }

  /** Moves the cursor by keys, and says aloud what it reads. */
  step(rows) {
    const [first, stop] = this.view;
    const from = this.cursor ?? Math.round((first + stop) / 2);
    const time = this.clock.timeOf(between(first, from + rows, stop - 1));
    const { plot } = this.panels[0];
    plot.setCursor({ left: plot.valToPos(time, "x"), top: 10 });
    this.point(time);
    $("said").textContent = $("readout").innerText.replace(/\s+/g, " ");
  }

  /** The legend, with the values at a row of the view; null or another row: without values. */
  readOut(row) {
    if (!this.drawn) return;
    const { first, stop, edges } = this.drawn;
    const inside = row !== null && row >= first && row < stop;
    const step = inside ? edges.slice(0, -1).findLastIndex((edge) => edge <= row) : -1;
    const out = $("readout");
    out.replaceChildren();
    if (step >= 0) out.append(element("span", "item", this.whereIs(row)));
    for (const entry of this.entries(step)) out.append(this.legendItem(entry));
    // Lines of the readout may come with the pointer, but the plots must not move under it each time.
    if (step >= 0) out.style.minHeight = `${out.offsetHeight}px`;
    this.box.dataset.cursor = step >= 0 ? String(row) : "";
  }

  whereIs(row) {
    const held = this.T.test.some(([first, stop]) => row >= first && row < stop);
    const log = this.T.logs.find(([, first, stop]) => row >= first && row < stop);
    const ofLog = this.T.logs.length > 1 && log ? `, ${log[0]}` : "";
    return `${digits(this.clock.timeOf(row), 1e-4)} s${held ? ", held out" : ", training"}${ofLog}`;
  }

  /** What the legend names: measured, the chosen models, inputs. At a step (not -1) each has its value. */
  entries(step) {
    const { effort, inputs } = this.T;
    const dashes = (dash) => (dash.length ? (dash[0] < 4 ? "dotted" : "dashed") : "solid");
    const entries = [{ name: "measured", colour: "--measured", line: "solid", value: this.valueAt(step, "measured", effort) }];
    for (const model of this.chosen) {
      const [colour, dash] = this.style(model);
      const residual = this.valueAt(step, `residual:${model}`, { factor: effort.factor });
      const value = this.valueAt(step, `estimate:${model}`, effort) + (residual ? `, off by ${residual}` : "");
      const canGo = step < 0 && this.chosen.length > 1;
      entries.push({ name: this.models.get(model).title, colour, line: dashes(dash), value, leaveOut: canGo ? model : null });
    }
    for (const input of inputs) {
      const ofKind = this.inputs(input.kind);
      if (step < 0 && ofKind.length < 2) continue; // its plot has its name
      const place = ofKind.indexOf(input);
      const value = this.valueAt(step, input.channel, input);
      entries.push({ name: input.label, colour: INPUT_COLOURS[place], line: place ? "dashed" : "solid", value });
    }
    return entries;
  }

  /** The value of a step, or its range, as text; empty without a step. */
  valueAt(step, name, { factor, unit }) {
    if (step < 0) return "";
    const resolution = this.channels[name].step * factor;
    const [low, high] = this.drawn.values[name][step].map((value) => value * factor);
    const text = low === high ? digits(low, resolution) : `${digits(low, resolution)} … ${digits(high, resolution)}`;
    return text + (unit ? ` ${unit}` : "");
  }

  legendItem({ name, colour, line, value, leaveOut = null }) {
    const item = element("span", "item");
    const mark = element("i");
    mark.style.borderTopColor = css(colour);
    mark.style.borderTopStyle = line;
    item.append(mark, element("span", "", name));
    if (value) item.append(element("span", "value", value));
    if (leaveOut) {
      const button = element("button", "", "×");
      button.type = "button";
      button.setAttribute("aria-label", `Leave out ${this.models.get(leaveOut).title}`);
      button.addEventListener("click", () => this.choose(this.chosen.filter((model) => model !== leaveOut)));
      item.append(button);
    }
    return item;
  }

  // --- the whole log as a strip

  stripWidth() { return this.strip.clientWidth - this.margin - MARGIN; }

  drawStrip() {
    const { strip, T } = this;
    const height = strip.clientHeight;
    const ratio = devicePixelRatio || 1;
    this.margin = this.panels[0].plot.over.offsetLeft;
    strip.width = strip.clientWidth * ratio;
    strip.height = height * ratio;
    const ctx = strip.getContext("2d");
    ctx.scale(ratio, ratio);
    const across = (row) => this.margin + (row / T.rows) * this.stripWidth();
    ctx.fillStyle = css("--held");
    for (const [first, stop] of T.test) ctx.fillRect(across(first), 0, across(stop) - across(first), height);

    const waiting = this.channels.measured.ready(0, T.rows);
    if (waiting) {
      waiting.then(() => this.drawStrip());
      return;
    }
    const ranges = this.stripRanges();
    const low = Math.min(...ranges.map(([least]) => least));
    const high = Math.max(...ranges.map(([, most]) => most));
    const scale = (height - 6) / (high - low || 1);
    ctx.fillStyle = css("--mut");
    ranges.forEach(([least, most], pixel) => {
      ctx.fillRect(this.margin + pixel, height - 3 - (most - low) * scale, 1, Math.max(1, (most - least) * scale));
    });

    const [first, stop] = this.view;
    ctx.strokeStyle = css("--link");
    ctx.lineWidth = 2;
    ctx.strokeRect(across(first), 1, Math.max(3, across(stop) - across(first)), height - 2);
  }

  /** Smallest and largest measured value of the rows of each pixel. */
  stripRanges() {
    const { measured } = this.channels;
    const { rows } = this.T;
    const layer = measured.pick(0, rows);
    const pixels = Math.floor(this.stripWidth());
    return Array.from({ length: pixels }, (_, pixel) => {
      const first = Math.floor((pixel * rows) / pixels);
      const stop = Math.floor(((pixel + 1) * rows) / pixels);
      return measured.range(layer, first, Math.max(first + 1, stop));
    });
  }

  /** A drag over the strip shows the rows under it; a click brings the view to where it is. */
  listenToStrip() {
    const { strip, T } = this;
    const least = T.rows / 200; // a shorter drag is a click
    const rowAt = (event) => {
      const pixels = event.clientX - strip.getBoundingClientRect().left - this.margin;
      return between(0, (pixels / this.stripWidth()) * T.rows, T.rows);
    };
    let from = null;
    strip.addEventListener("pointerdown", (event) => {
      from = rowAt(event);
      this.remember();
      strip.setPointerCapture(event.pointerId);
    });
    strip.addEventListener("pointermove", (event) => {
      if (from === null) return;
      const to = rowAt(event);
      if (Math.abs(to - from) > least) this.go(Math.min(from, to), Math.max(from, to));
    });
    strip.addEventListener("pointerup", (event) => {
      const to = rowAt(event);
      const width = this.view[1] - this.view[0];
      if (from !== null && Math.abs(to - from) <= least) this.go(to - width / 2, to + width / 2);
      from = null;
    });
  }
}

if (DATA.traces) {
  if (typeof DecompressionStream === "undefined") $("readout").textContent = "This browser is too old for this plot; all others are here.";
  else new Traces(DATA.traces);
}
