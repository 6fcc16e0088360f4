// The charts: one time axis, ranges that follow the data calmly, spans outside the training range shaded.

import { named } from "./store.js";

export const shownUnit = unit => ({ "": "1", "?": "as logged" })[unit] ?? unit.replace("*", " ");
export const effortCalled = unit => ({ "N*m": "Torque", N: "Force", Pa: "Stress" })[unit] ?? "Effort";

// The charts of a device: those of the pair name its two sides, a single device's the one channel.
export function chartsOf(channels) {
  const of = role => channels.filter(channel => channel.role === role), pair = of("field").length > 1;
  const lines = (role, colours) => of(role).map(({ name, label }, k) => [name, label, colours[k]]);
  const unit = role => shownUnit(of(role).at(-1).unit), measured = named(channels, "effort").map(name => [name, "measured", "--measured"]);
  return [
    { title: effortCalled(of("estimate")[0].unit), unit: unit("estimate"), lines: [...measured, ["estimate", "estimate", "--estimated"], ["wanted_effort", "reference", "--text"]], least: 0.004 },
    ...measured.length ? [{ title: "Residual", unit: unit("estimate"), lines: [["residual", "measured − estimate", "--residual"]], least: 0.002 }] : [],
    ...pair ? [{ title: "Tracking", unit: unit("position"), lines: [["wanted_position", "reference", "--text"], [named(channels, "position").at(-1), "output", "--output"], ["error", "error", "--residual"]], least: 0.1, tracking: true }] : [],
    { title: pair ? "Field E" : "Field", unit: unit("field"), axis: pair ? "E" : undefined, lines: lines("field", ["--one", "--two"]), fixed: pair, least: 0.001 },
    { title: pair ? "Speed" : "Slip", unit: unit("speed"), lines: lines("speed", pair ? ["--motor", "--output"] : ["--output"]), least: unit("speed") === "m/s" ? 0.01 : 1 },
  ];
}

const colour = name => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
export const signed = (value, digits) => Number.isFinite(value) ? (value < 0 ? "−" : "+") + Math.abs(value).toFixed(digits) : "–";

// An element with some properties and what stands in it.
export function element(kind, properties, ...children) {
  const node = Object.assign(document.createElement(kind), properties);
  node.append(...children);
  return node;
}

// Digits after the point that tell a five hundredth of a span.
export const digitsFor = span => Math.min(5, Math.max(1, Math.ceil(2.7 - Math.log10(span))));

// Ticks with as many digits as their step has: 0.0075, 0.0050, 0.0025.
export function tickTexts(ticks, step) {
  let digits = 0;
  while (digits < 9 && Math.abs(step.toFixed(digits) / step - 1) > 1e-6) digits += 1;
  return ticks.map(tick => tick.toFixed(digits).replace("-", "−"));
}

// Multiples of a step within a low chart; of half of it where that leaves a zero alone, which says nothing of the scale.
export function ticksOf(low, high, step) {
  const multiples = size => {
    const first = Math.ceil(low / size - 1e-9), last = Math.floor(high / size + 1e-9);
    return Array.from({ length: Math.max(0, last - first + 1) }, (_, k) => (first + k) * size);
  };
  const found = multiples(step);
  return found.length > 1 ? found : multiples(step / 2);
}

function niceStep(span) {
  const power = 10 ** Math.floor(Math.log10(span));
  return (span / power < 2 ? 0.5 : span / power < 5 ? 1 : 2) * power;
}

// Grows at once, shrinks only when it has been far too large for a while.
class Range {
  constructor(least) { this.least = least; this.low = -least; this.high = least; this.small = 0; }

  follow(lines, now) {
    let low = Infinity, high = -Infinity;
    for (const line of lines) for (const value of line) if (value !== null) { if (value < low) low = value; if (value > high) high = value; }
    if (low > high) return;
    const middle = (low + high) / 2, half = Math.max((high - low) / 2 * 1.08, this.least / 2), step = niceStep(2 * half) / 2;
    const wantedLow = Math.floor((middle - half) / step) * step, wantedHigh = Math.ceil((middle + half) / step) * step;
    if (wantedLow < this.low || wantedHigh > this.high) {
      this.low = Math.min(this.low, wantedLow); this.high = Math.max(this.high, wantedHigh); this.small = now;
    }
    if (wantedHigh - wantedLow > 0.7 * (this.high - this.low)) this.small = now;
    else if (now - this.small > 1500) { this.low = wantedLow; this.high = wantedHigh; this.small = now; }
  }
}

export class Charts {
  constructor(root, store) {
    this.store = store;
    this.limit = 0.5;
    this.root = root; this.charts = []; this.made = "";
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.#rebuild());
    this.observer = new ResizeObserver(() => this.resize());
  }

  // The session's channels, each time that a server tells them.
  set channels(channels) {
    if (JSON.stringify(channels) === this.made) return;
    this.made = JSON.stringify(channels);
    this.observer.disconnect();
    for (const made of this.charts) made.uplot.destroy();
    this.root.replaceChildren();
    this.charts = [];
    for (const chart of chartsOf(channels)) this.charts.push(this.#make(this.root, chart));
    for (const made of this.charts) this.observer.observe(made.plot);
    this.resize();
  }

  #make(root, chart) {
    const values = chart.lines.map(() => element("span"));
    const keys = chart.lines.map(([name, label, variable], k) => {
      const swatch = element("i");
      swatch.style.background = `var(${variable})`;
      return element("span", { className: "key", hidden: name === "wanted_effort" }, swatch, label, element("span", {}, values[k]));
    });
    const plot = element("div", { className: "plot" });
    const box = element("div", { className: "chart", hidden: Boolean(chart.tracking) }, element("h2", {}, `${chart.title} [${chart.unit}]`, ...keys), plot);
    box.setAttribute("role", "group"); box.setAttribute("aria-label", `${chart.title} in ${chart.unit}`);
    root.append(box);
    const made = { chart, box, plot, values, keys, range: new Range(chart.least ?? 1), outside: [], times: [0, 1], zoom: null };
    made.uplot = this.#plot(made);
    return made;
  }

  #plot(made) {
    const axis = { stroke: colour("--soft"), grid: { stroke: colour("--grid"), width: 1 }, ticks: { show: false }, font: "11px system-ui, sans-serif" };
    // Charts that stand together on a wide screen have one row of times, below the last.
    const timed = () => !made.box.nextSibling || innerWidth <= 900;
    const options = {
      width: Math.max(100, made.plot.clientWidth), height: Math.max(60, made.plot.clientHeight),
      padding: [8, 8, 0, 0], legend: { show: false }, cursor: { sync: { key: "live" }, drag: { x: true, y: false, setScale: false }, points: { size: 6 } },
      scales: { x: { time: false, range: () => made.zoom ?? made.times }, y: { range: () => made.chart.fixed ? [-0.04 * this.limit, 1.06 * this.limit] : [made.range.low, made.range.high] } },
      axes: [{ ...axis, size: () => timed() ? 26 : 8, gap: 4, values: (_, ticks) => ticks.map(t => timed() ? `${+t.toFixed(3)} s` : "") }, { ...axis, size: 50, gap: 4, space: 18, splits: (_, __, low, high, step) => ticksOf(low, high, step), values: (_, ticks, __, ___, step) => tickTexts(ticks, ticks.length > 1 ? ticks[1] - ticks[0] : step), label: made.chart.axis ?? made.chart.unit, labelSize: 16, labelGap: 0, labelFont: axis.font }],
      series: [{}, ...made.chart.lines.map(([, , variable]) => ({ stroke: colour(variable), width: devicePixelRatio > 1 ? 1.25 : 1, points: { show: false }, spanGaps: false }))],
      hooks: {
        drawClear: [u => this.#shade(u, made)],
        setSelect: [u => { if (this.frozen && u.select.width > 5) this.zoom([u.posToVal(u.select.left, "x"), u.posToVal(u.select.left + u.select.width, "x")]); u.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false); }],
        ready: [u => u.over.addEventListener("dblclick", () => this.zoom(null))],
      },
    };
    return new uPlot(options, [[], ...made.chart.lines.map(() => [])], made.plot);
  }

  #shade(u, made) {
    if (!made.outside.length || made.chart.fixed) return;
    const context = u.ctx;
    context.save(); context.fillStyle = colour("--bad-soft");
    const { left, top, width, height } = u.bbox;
    for (let i = 0; i < made.outside.length; i += 2) {
      const from = Math.max(left, u.valToPos(made.outside[i], "x", true)), to = Math.min(left + width, u.valToPos(made.outside[i + 1], "x", true));
      if (to >= from) context.fillRect(from, top, Math.max(1, to - from), height);
    }
    context.restore();
  }

  #rebuild() {
    for (const made of this.charts) { made.uplot.destroy(); made.uplot = this.#plot(made); }
    this.resize(); this.draw(this.times, performance.now());
  }

  resize() {
    for (const made of this.charts) {
      const width = made.plot.clientWidth, height = made.plot.clientHeight;
      if (width > 20 && height > 20 && (width !== made.uplot.width || height !== made.uplot.height)) made.uplot.setSize({ width, height });
    }
  }

  zoom(range) {
    for (const made of this.charts) made.zoom = range;
    if (this.times) this.draw(this.times, performance.now());
  }

  // times: first and last second to show; while frozen a zoom is read anew at full detail.
  draw(times, now) {
    this.times = times;
    // Two points every other pixel, and lines of one pixel: without a graphics card the browser's time goes into strokes.
    for (const made of this.charts) {
      const [from, to] = made.zoom ?? times;
      const { data, outside } = this.store.decimate(made.chart.lines.map(line => line[0]), from, to, made.uplot.width / 2);
      made.times = times; made.outside = merged(outside);
      if (!made.chart.fixed) made.range.follow(data.slice(1), now);
      made.uplot.setData(data);
    }
  }

  // What runs tracks a "position", an "effort" or nothing.
  set reference(tracked) {
    for (const { chart, box, keys } of this.charts) {
      if (chart.tracking) box.hidden = tracked !== "position";
      chart.lines.forEach(([name], k) => { if (name === "wanted_effort") keys[k].hidden = tracked !== "effort"; });
    }
  }

  // The newest numbers in the heads of the charts: to a five hundredth of what the chart spans.
  label() {
    for (const made of this.charts) made.chart.lines.forEach(([name], k) => {
      const text = signed(this.store.last(name), made.chart.fixed ? 3 : digitsFor(made.range.high - made.range.low));
      if (made.values[k].textContent !== text) made.values[k].textContent = text;
    });
  }
}

function merged(spans) {
  const out = [];
  for (let i = 0; i < spans.length; i += 2) {
    if (out.length && spans[i] - out[out.length - 1] < 0.02) out[out.length - 1] = spans[i + 1];
    else out.push(spans[i], spans[i + 1]);
  }
  return out;
}
