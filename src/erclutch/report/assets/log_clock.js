"use strict";
// Rows and times of a log.

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

  /** The knots before and after a value. */
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
