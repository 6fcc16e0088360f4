"use strict";
// The whole log as a strip below the traces, with the rows in view framed.

const MARGIN = 6; // pixels right of the plots and of the strip

class Strip {
  /** traces: whose view it shows, and moves. */
  constructor(traces) {
    this.traces = traces;
    this.canvas = $("overview");
    this.left = 0; // where its rows begin, below those of the plots [px]
    this.listen();
  }

  get width() { return this.canvas.clientWidth - this.left - MARGIN; }

  across(row) { return this.left + (row / this.traces.T.rows) * this.width; }

  draw() {
    const { canvas, traces } = this;
    const { T, channels } = traces;
    const height = canvas.clientHeight;
    const ratio = devicePixelRatio || 1;
    this.left = traces.panels[0].plot.over.offsetLeft;
    canvas.width = canvas.clientWidth * ratio;
    canvas.height = height * ratio;
    const ctx = canvas.getContext("2d");
    ctx.scale(ratio, ratio);
    ctx.fillStyle = css("--held");
    for (const [first, stop] of T.test) ctx.fillRect(this.across(first), 0, this.across(stop) - this.across(first), height);

    const waiting = channels.measured.ready(0, T.rows);
    if (waiting) waiting.then(() => this.draw());
    else this.drawMeasured(ctx, height);
  }

  drawMeasured(ctx, height) {
    const ranges = this.rangesOfPixels();
    const low = Math.min(...ranges.map(([least]) => least));
    const high = Math.max(...ranges.map(([, most]) => most));
    const scale = (height - 6) / (high - low || 1);
    ctx.fillStyle = css("--mut");
    ranges.forEach(([least, most], pixel) => {
      const top = height - 3 - (most - low) * scale;
      ctx.fillRect(this.left + pixel, top, 1, Math.max(1, (most - least) * scale));
    });

    const [first, stop] = this.traces.view;
    const width = Math.max(3, this.across(stop) - this.across(first));
    ctx.strokeStyle = css("--link");
    ctx.lineWidth = 2;
    ctx.strokeRect(this.across(first), 1, width, height - 2);
  }

  /** Smallest and largest measured value of the rows of each pixel. */
  rangesOfPixels() {
    const { measured } = this.traces.channels;
    const { rows } = this.traces.T;
    const layer = measured.pick(0, rows);
    const pixels = Math.floor(this.width);
    return Array.from({ length: pixels }, (_, pixel) => {
      const first = Math.floor((pixel * rows) / pixels);
      const stop = Math.floor(((pixel + 1) * rows) / pixels);
      return measured.range(layer, first, Math.max(first + 1, stop));
    });
  }

  rowAt(event) {
    const { rows } = this.traces.T;
    const pixels = event.clientX - this.canvas.getBoundingClientRect().left - this.left;
    return between(0, (pixels / this.width) * rows, rows);
  }

  /** A drag shows the rows under it; a click brings the view to where it is. */
  listen() {
    const { canvas, traces } = this;
    const least = traces.T.rows / 200; // a shorter drag is a click
    let from = null;
    canvas.addEventListener("pointerdown", (event) => {
      from = this.rowAt(event);
      traces.remember();
      canvas.setPointerCapture(event.pointerId);
    });
    canvas.addEventListener("pointermove", (event) => {
      if (from === null) return;
      const to = this.rowAt(event);
      if (Math.abs(to - from) > least) traces.go(Math.min(from, to), Math.max(from, to));
    });
    canvas.addEventListener("pointerup", (event) => {
      const to = this.rowAt(event);
      const [first, stop] = traces.view;
      const half = (stop - first) / 2;
      if (from !== null && Math.abs(to - from) <= least) traces.go(to - half, to + half);
      from = null;
    });
    canvas.addEventListener("pointercancel", () => { from = null; }); // the browser has taken the drag for its own
  }
}
