"use strict";
// Measured against estimated: plots that can be zoomed, with cursor, legend and the whole log as a strip.
//
// Three values say what is on screen: the rows in view, the chosen models, and the row under the cursor. Whoever changes
// one asks for a new drawing. `sample` then takes as much of the rows as the width can show, and each plot draws it.

const AXIS = 58; // pixels of the vertical axis
const MOST_MODELS = 4;
const FEWEST_ROWS = 20; // in view
const COLOURS = { recommended: "--recommended", best: "--best", baseline: "--baseline" };
const DASHES = { recommended: [], best: [7, 4], baseline: [2, 3] };
const OTHERS = ["--other1", "--other2", "--other3"];
const INPUT_COLOURS = ["--measured", "--mut"]; // of both clutches of a pair
const FONT = "11px system-ui, sans-serif";

const inBrackets = (unit) => (unit ? ` [${unit}]` : "");

class Traces {
  /** T: what `traces_section.py` says of the log, its models and its channels. */
  constructor(T) {
    this.T = T;
    this.box = $("traces-plot");
    this.strip = new Strip(this);
    this.readout = new Readout(this);
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

    this.listenToButtons();
    this.listenToWheel();
    this.listenToKeys();
    this.listenToList();
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
      if (!inputs.length) continue; // a log without a field
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
    this.strip.draw();
    this.readout.show(this.cursor);
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
      this.strip.draw();
      this.readout.show(this.cursor);
    });
    let width = this.box.clientWidth;
    addEventListener("resize", () => {
      if (this.box.clientWidth === width) return;
      width = this.box.clientWidth;
      this.build();
      this.later();
    });
  }

  // --- cursor

  point(time) {
    this.cursor = time === null ? null : Math.round(this.clock.rowOf(time));
    this.readout.show(this.cursor);
  }

  /** Moves the cursor by keys, and says aloud what it reads. */
  step(rows) {
    const [first, stop] = this.view;
    const from = this.cursor ?? Math.round((first + stop) / 2);
    const time = this.clock.timeOf(between(first, from + rows, stop - 1));
    const { plot } = this.panels[0];
    plot.setCursor({ left: plot.valToPos(time, "x"), top: 10 });
    this.point(time);
    this.readout.sayAloud();
  }
}

if (DATA.traces) {
  if (typeof DecompressionStream === "undefined") $("readout").textContent = "This browser is too old for this plot; all others are here.";
  else new Traces(DATA.traces);
}
