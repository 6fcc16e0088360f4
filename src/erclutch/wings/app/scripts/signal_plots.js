// The signals of a log over time: looked at closer, and trimmed.

import { $, ask, css, fieldsOf } from "./page.js";

const FONT = "11px system-ui";
const SHORTEST_DRAG = 3; // px
const CLOSEST = 1e-4; // share of the log that can be seen alone
const FEW_POINTS = 200; // in view: finer ones are asked for
const RESTING = 300; // ms after the last move, until they are
const SLACK = 0.02; // of the view, on both sides

const sixDigits = value => +value.toPrecision(6);

export function showSignals() {
  if ($("courses")) new SignalPlots($("courses"), $("reading"), JSON.parse($("over-time").textContent));
}

class SignalPlots {
  /** whole: `{time, until, signals: {name: {unit, low, high}}}`, as few points as show the whole log. */
  constructor(box, form, whole) {
    this.box = box;
    this.form = form;
    this.whole = whole;
    this.points = whole; // what is drawn: of the whole log, or finer ones of the view
    this.first = whole.time[0];
    this.last = whole.until;
    this.view = [this.first, this.last]; // s
    this.earlier = []; // views
    this.moves = 0;
    this.plots = []; // [name, plot]
    this.dragged = null; // the plot in which the mouse went down

    this.listenToButtons();
    this.listenToKeys();
    addEventListener("resize", () => this.build());
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.build());
    this.build();
  }

  // --- plots

  build() {
    for (const [, plot] of this.plots) plot.destroy();
    this.plots = Object.keys(this.whole.signals).map(name => [name, this.plotOf(name)]);
    this.draw();
  }

  plotOf(name) {
    const line = { stroke: () => css("--ink"), width: 1, points: { show: false } };
    const options = {
      width: $("plots").clientWidth,
      height: 104,
      padding: [6, 8, 0, 0],
      scales: { x: { time: false } },
      legend: { show: false },
      cursor: {
        sync: { key: "courses", setSeries: false },
        drag: { x: true, y: false, setScale: false },
        points: { show: false },
      },
      axes: [timeAxis(), valueAxis(name, this.whole.signals[name].unit)],
      series: [{}, line, { ...line }], // smallest and largest value, and the band between them
      bands: [{ series: [2, 1], fill: () => css("--ink") }],
      hooks: { setSelect: [plot => this.selected(plot)] },
    };
    const plot = new uPlot(options, this.rowsOf(name), $("plots"));
    plot.over.addEventListener("mousedown", () => { this.dragged = plot; }, true);
    plot.over.addEventListener("dblclick", () => this.goBack());
    return plot;
  }

  rowsOf(name) {
    const signal = this.points.signals[name];
    return signal ? [this.points.time, signal.low, signal.high] : [[0], [null], [null]];
  }

  draw() {
    const [from, to] = this.view;
    for (const [name, plot] of this.plots) {
      plot.batch(() => {
        plot.setData(this.rowsOf(name), false);
        plot.setScale("x", { min: from, max: to });
      });
    }
    this.box.dataset.view = this.view.map(sixDigits).join(",");
    $("seen").textContent = this.whatIsSeen();
  }

  whatIsSeen() {
    const [from, to] = this.view;
    const seen = `${sixDigits(from)} s to ${sixDigits(to)} s`;
    const isAll = from === this.first && to === this.last;
    if (!isAll) return `${seen} of ${sixDigits(this.first)} s to ${sixDigits(this.last)} s`;
    const isTrimmed = this.cuts().some(field => field.defaultValue);
    return `${seen}, ${isTrimmed ? "all that the trimming leaves" : "the whole log"}`;
  }

  /** A drag has ended. The other plots follow this one's drag: they only let go of it. */
  selected(plot) {
    const { left, width } = plot.select;
    plot.setSelect({ left: 0, width: 0, top: 0, height: 0 }, false);
    if (plot !== this.dragged || width <= SHORTEST_DRAG) return;
    this.lookAt(plot.posToVal(left, "x"), plot.posToVal(left + width, "x"));
  }

  // --- where to look

  lookAt(from, to) {
    this.earlier.push(this.view);
    this.go(from, to);
  }

  goBack() {
    const [from, to] = this.earlier.pop() ?? [this.first, this.last];
    this.go(from, to);
  }

  /** Shows a view at once with the points that are there, and with finer ones as soon as it rests. */
  async go(from, to) {
    const width = Math.max(to - from, (this.last - this.first) * CLOSEST);
    const start = Math.max(this.first, Math.min(this.last - width, from));
    this.view = [start, Math.min(start + width, this.last)];
    this.points = this.whole;
    this.draw();

    this.moves += 1;
    const move = this.moves;
    const inView = this.whole.time.filter(time => time >= this.view[0] && time <= this.view[1]);
    if (inView.length > FEW_POINTS) return;
    await new Promise(rested => setTimeout(rested, RESTING));
    if (move !== this.moves) return;
    const finer = await this.finerPoints();
    if (move !== this.moves || finer.problem) return;
    this.points = finer;
    this.draw();
  }

  finerPoints() {
    const [from, to] = this.view;
    const slack = SLACK * (to - from);
    const fields = fieldsOf(this.form);
    fields.set("from", `${Math.max(this.first, from - slack)}s`);
    fields.set("until", `${Math.min(this.last, to + slack)}s`);
    fields.delete("skip");
    return ask(`${this.box.dataset.course}?${fields}`);
  }

  zoom(factor) {
    const [from, to] = this.view;
    const middle = (from + to) / 2;
    const half = (factor * (to - from)) / 2;
    this.lookAt(middle - half, middle + half);
  }

  pan(share) {
    const [from, to] = this.view;
    const seconds = share * (to - from);
    this.lookAt(from + seconds, to + seconds);
  }

  // --- trimming: the form reads the log again

  cuts() { return ["from", "until", "skip"].map(name => this.form.elements[name]); }

  trim() {
    const [from, to] = this.view;
    const { from: begin, until: end, skip } = this.form.elements;
    if (from > this.first) {
      begin.value = `${sixDigits(from)}s`;
      skip.value = "";
    }
    if (to < this.last) end.value = `${sixDigits(to)}s`;
    this.form.requestSubmit();
  }

  untrim() {
    for (const field of this.cuts()) field.value = "";
    this.form.requestSubmit();
  }

  // --- buttons and keys

  showAll() { this.lookAt(this.first, this.last); }

  listenToButtons() {
    const acts = {
      out: () => this.zoom(2),
      whole: () => this.showAll(),
      trim: () => this.trim(),
      untrim: () => this.untrim(),
    };
    for (const button of this.box.querySelectorAll("[data-do]")) {
      button.addEventListener("click", acts[button.dataset.do]);
    }
  }

  listenToKeys() {
    const acts = {
      ArrowLeft: () => this.pan(-0.25),
      ArrowRight: () => this.pan(0.25),
      "+": () => this.zoom(0.5),
      "=": () => this.zoom(0.5),
      "-": () => this.zoom(2),
      Home: () => this.showAll(),
      Enter: () => this.trim(),
    };
    this.box.addEventListener("keydown", event => {
      if (event.target !== this.box || !acts[event.key]) return;
      event.preventDefault();
      acts[event.key]();
    });
  }
}

function timeAxis() {
  return {
    size: 22,
    stroke: () => css("--soft"),
    grid: { show: false },
    ticks: { size: 4, stroke: () => css("--line") },
  };
}

function valueAxis(name, unit) {
  const isKnown = /[^?]/.test(unit);
  return {
    size: 62,
    space: 22,
    stroke: () => css("--soft"),
    label: isKnown ? `${name} [${unit.replace("*", "·")}]` : name,
    labelSize: 16,
    labelFont: FONT,
    font: FONT,
    grid: { stroke: () => css("--line"), width: 0.6 },
    ticks: { show: false },
  };
}
