// The charts: one time axis, ranges that follow the data calmly, spans outside the training range shaded.

import { CalmRange, tickTexts, ticksOf } from "./axis_ticks.js";
import { colourOf, element, whenColoursTurn } from "./elements.js";
import { digitsFor, effortCalled, shownUnit, signed } from "./number_texts.js";
import { named } from "./store.js";

const FONT = "11px system-ui, sans-serif";
const STACKED = 900; // px of the window, up to which charts stand alone
const SHORTEST_DRAG = 5; // px
const NEAR = 0.02; // s: spans that are nearer are shaded as one

/** The charts of a device: those of the pair name its two sides, a single device's the one channel. Lines are [name, label, colour]. */
export function chartsOf(channels) {
  const of = role => channels.filter(channel => channel.role === role);
  const unit = role => shownUnit(of(role).at(-1).unit);
  const linesOf = (role, colours) => of(role).map(({ name, label }, k) => [name, label, colours[k]]);
  const pair = of("field").length > 1;
  const measured = named(channels, "effort").map(name => [name, "measured", "--measured"]);

  const effort = {
    title: effortCalled(of("estimate")[0].unit),
    unit: unit("estimate"),
    lines: [...measured, ["estimate", "estimate", "--estimated"], ["wanted_effort", "reference", "--text"]],
    least: 0.004,
  };
  const residual = {
    title: "Residual",
    unit: unit("estimate"),
    lines: [["residual", "measured − estimate", "--residual"]],
    least: 0.002,
  };
  const tracking = {
    title: "Tracking",
    unit: unit("position"),
    lines: [
      ["wanted_position", "reference", "--text"],
      [named(channels, "position").at(-1), "output", "--output"],
      ["error", "error", "--residual"],
    ],
    least: 0.1,
    tracking: true,
  };
  const field = {
    title: pair ? "Field E" : "Field",
    unit: unit("field"),
    axis: pair ? "E" : undefined,
    lines: linesOf("field", ["--one", "--two"]),
    fixed: pair, // to the field's limit
    least: 0.001,
  };
  const speed = {
    title: pair ? "Speed" : "Slip",
    unit: unit("speed"),
    lines: linesOf("speed", pair ? ["--motor", "--output"] : ["--output"]),
    least: unit("speed") === "m/s" ? 0.01 : 1,
  };

  const charts = [effort];
  if (measured.length) charts.push(residual);
  if (pair) charts.push(tracking);
  return [...charts, field, speed];
}

/** One chart: its head with the newest numbers, and its plot. */
class Chart {
  constructor(root, shape, charts) {
    this.shape = shape;
    this.charts = charts;
    this.names = shape.lines.map(([name]) => name);
    this.range = new CalmRange(shape.least);
    this.outside = []; // spans far from all training rows: from, to, from, to, ... [s]
    this.times = [0, 1];
    this.zoom = null; // times that are looked at closer, while frozen

    this.values = shape.lines.map(() => element("span"));
    this.keys = shape.lines.map((line, k) => this.#key(line, this.values[k]));
    this.plot = element("div", { className: "plot" });
    const head = element("h2", {}, `${shape.title} [${shape.unit}]`, ...this.keys);
    this.box = element("div", { className: "chart", hidden: Boolean(shape.tracking) }, head, this.plot);
    this.box.setAttribute("role", "group");
    this.box.setAttribute("aria-label", `${shape.title} in ${shape.unit}`);
    root.append(this.box);
    this.rebuild();
  }

  #key([name, label, colour], value) {
    const swatch = element("i");
    swatch.style.background = `var(${colour})`;
    const hidden = name === "wanted_effort"; // until a program tracks it
    return element("span", { className: "key", hidden }, swatch, label, element("span", {}, value));
  }

  /** A new plot, in the colours that the page now has. */
  rebuild() {
    this.uplot?.destroy();
    const lines = this.shape.lines.map(([, , colour]) => ({
      stroke: colourOf(colour),
      width: devicePixelRatio > 1 ? 1.25 : 1,
      points: { show: false },
      spanGaps: false,
    }));
    const options = {
      width: Math.max(100, this.plot.clientWidth),
      height: Math.max(60, this.plot.clientHeight),
      padding: [8, 8, 0, 0],
      legend: { show: false },
      cursor: { sync: { key: "live" }, drag: { x: true, y: false, setScale: false }, points: { size: 6 } },
      scales: {
        x: { time: false, range: () => this.zoom ?? this.times },
        y: { range: () => this.#span() },
      },
      axes: this.#axes(),
      series: [{}, ...lines],
      hooks: {
        drawClear: [uplot => this.#shade(uplot)],
        setSelect: [uplot => this.#dragged(uplot)],
        ready: [uplot => uplot.over.addEventListener("dblclick", () => this.charts.zoom(null))],
      },
    };
    this.uplot = new uPlot(options, [[], ...lines.map(() => [])], this.plot);
  }

  #span() {
    if (!this.shape.fixed) return [this.range.low, this.range.high];
    const { limit } = this.charts;
    return [-0.04 * limit, 1.06 * limit];
  }

  #axes() {
    const axis = {
      stroke: colourOf("--soft"),
      grid: { stroke: colourOf("--grid"), width: 1 },
      ticks: { show: false },
      font: FONT,
      gap: 4,
    };
    // Charts that stand together on a wide screen have one row of times, below the last.
    const timed = () => !this.box.nextSibling || innerWidth <= STACKED;
    const time = {
      ...axis,
      size: () => (timed() ? 26 : 8),
      values: (_, ticks) => ticks.map(tick => (timed() ? `${+tick.toFixed(3)} s` : "")),
    };
    const value = {
      ...axis,
      size: 50,
      space: 18,
      splits: (_, __, low, high, step) => ticksOf(low, high, step),
      values: (_, ticks, __, ___, step) => tickTexts(ticks, ticks.length > 1 ? ticks[1] - ticks[0] : step),
      label: this.shape.axis ?? this.shape.unit,
      labelSize: 16,
      labelGap: 0,
      labelFont: FONT,
    };
    return [time, value];
  }

  /** A drag over a frozen chart: its times come into view, in all charts. */
  #dragged(uplot) {
    const { left, width } = uplot.select;
    if (this.charts.frozen && width > SHORTEST_DRAG) {
      this.charts.zoom([uplot.posToVal(left, "x"), uplot.posToVal(left + width, "x")]);
    }
    uplot.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false);
  }

  #shade(uplot) {
    if (!this.outside.length || this.shape.fixed) return;
    const { left, top, width, height } = uplot.bbox;
    const across = time => uplot.valToPos(time, "x", true);
    uplot.ctx.save();
    uplot.ctx.fillStyle = colourOf("--bad-soft");
    for (let k = 0; k < this.outside.length; k += 2) {
      const from = Math.max(left, across(this.outside[k]));
      const to = Math.min(left + width, across(this.outside[k + 1]));
      if (to >= from) uplot.ctx.fillRect(from, top, Math.max(1, to - from), height);
    }
    uplot.ctx.restore();
  }

  resize() {
    const { clientWidth: width, clientHeight: height } = this.plot;
    if (width <= 20 || height <= 20) return; // hidden
    if (width !== this.uplot.width || height !== this.uplot.height) this.uplot.setSize({ width, height });
  }

  draw(times, now) {
    const [from, to] = this.zoom ?? times;
    // Two points every other pixel, and lines of one pixel: without a graphics card the browser's time goes into strokes.
    const { data, outside } = this.charts.store.decimate(this.names, from, to, this.uplot.width / 2);
    this.times = times;
    this.outside = joined(outside);
    if (!this.shape.fixed) this.range.follow(data.slice(1), now);
    this.uplot.setData(data);
  }

  /** What runs tracks a "position", an "effort" or nothing. */
  track(tracked) {
    if (this.shape.tracking) this.box.hidden = tracked !== "position";
    const wanted = this.names.indexOf("wanted_effort");
    if (wanted >= 0) this.keys[wanted].hidden = tracked !== "effort";
  }

  /** The newest numbers in the head: to a five hundredth of what the chart spans. */
  label() {
    const digits = this.shape.fixed ? 3 : digitsFor(this.range.high - this.range.low);
    this.names.forEach((name, k) => {
      const text = signed(this.charts.store.last(name), digits);
      if (this.values[k].textContent !== text) this.values[k].textContent = text;
    });
  }
}

/** All charts of a session. */
export class Charts {
  constructor(root, store) {
    this.root = root;
    this.store = store;
    this.limit = 0.5; // of the field
    this.frozen = false;
    this.charts = [];
    this.made = ""; // the channels for which the charts were made
    this.observer = new ResizeObserver(() => this.resize());
    whenColoursTurn(() => {
      for (const chart of this.charts) chart.rebuild();
      this.resize();
      this.#drawAgain();
    });
  }

  /** The session's channels, each time that a server tells them. */
  set channels(channels) {
    const made = JSON.stringify(channels);
    if (made === this.made) return;
    this.made = made;
    this.observer.disconnect();
    for (const chart of this.charts) chart.uplot.destroy();
    this.root.replaceChildren();
    this.charts = chartsOf(channels).map(shape => new Chart(this.root, shape, this));
    for (const chart of this.charts) this.observer.observe(chart.plot);
    this.resize();
  }

  set reference(tracked) {
    for (const chart of this.charts) chart.track(tracked);
  }

  /** What the chart of the effort spans. */
  get effortSpan() {
    const { high, low } = this.charts[0].range;
    return high - low;
  }

  resize() {
    for (const chart of this.charts) chart.resize();
  }

  zoom(times) {
    for (const chart of this.charts) chart.zoom = times;
    this.#drawAgain();
  }

  /** times: first and last second to show; while frozen a zoom is read anew at full detail. */
  draw(times, now) {
    this.times = times;
    for (const chart of this.charts) chart.draw(times, now);
  }

  #drawAgain() {
    if (this.times) this.draw(this.times, performance.now());
  }

  label() {
    for (const chart of this.charts) chart.label();
  }
}

function joined(spans) {
  const out = [];
  for (let k = 0; k < spans.length; k += 2) {
    const near = out.length && spans[k] - out[out.length - 1] < NEAR;
    if (near) out[out.length - 1] = spans[k + 1];
    else out.push(spans[k], spans[k + 1]);
  }
  return out;
}
