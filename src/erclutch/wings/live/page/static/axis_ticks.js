// Where the ticks of an axis stand, and the range that an axis shows.

/** Ticks with as many digits as their step has: 0.0075, 0.0050, 0.0025. */
export function tickTexts(ticks, step) {
  let digits = 0;
  while (digits < 9 && Math.abs(step.toFixed(digits) / step - 1) > 1e-6) digits += 1;
  return ticks.map(tick => tick.toFixed(digits).replace("-", "−"));
}

/** Multiples of a step within a low chart; of half of it where a zero would stand alone, which says nothing of the scale. */
export function ticksOf(low, high, step) {
  const ticks = multiples(low, high, step);
  return ticks.length > 1 ? ticks : multiples(low, high, step / 2);
}

function multiples(low, high, step) {
  const first = Math.ceil(low / step - 1e-9);
  const last = Math.floor(high / step + 1e-9);
  const count = Math.max(0, last - first + 1);
  return Array.from({ length: count }, (_, k) => (first + k) * step);
}

const SLACK = 1.08; // room above and below the lines
const LARGE = 0.7; // lines that fill this share leave the range as it is
const PATIENCE = 1500; // ms for which a range stays too large

/** A range that grows at once, and shrinks only when it has been far too large for a while. */
export class CalmRange {
  /** least: the smallest span that is worth a look. */
  constructor(least) {
    this.least = least;
    this.low = -least;
    this.high = least;
    this.filled = 0; // when the lines last filled the range
  }

  follow(lines, now) {
    const [least, most] = ends(lines);
    if (least > most) return; // nothing to draw

    const middle = (least + most) / 2;
    const half = Math.max(((most - least) / 2) * SLACK, this.least / 2);
    const step = niceStep(2 * half) / 2;
    const low = Math.floor((middle - half) / step) * step;
    const high = Math.ceil((middle + half) / step) * step;

    if (low < this.low || high > this.high) {
      this.low = Math.min(this.low, low);
      this.high = Math.max(this.high, high);
      this.filled = now;
    }
    if (high - low > LARGE * (this.high - this.low)) {
      this.filled = now;
    } else if (now - this.filled > PATIENCE) {
      this.low = low;
      this.high = high;
      this.filled = now;
    }
  }
}

/** Smallest and largest value of all lines, whose gaps are null. */
function ends(lines) {
  let least = Infinity;
  let most = -Infinity;
  for (const line of lines) {
    for (const value of line) {
      if (value === null) continue;
      if (value < least) least = value;
      if (value > most) most = value;
    }
  }
  return [least, most];
}

function niceStep(span) {
  const power = 10 ** Math.floor(Math.log10(span));
  const leading = span / power;
  if (leading < 2) return 0.5 * power;
  if (leading < 5) return power;
  return 2 * power;
}
