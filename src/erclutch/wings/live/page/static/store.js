// The samples of the last minute, in typed arrays that wrap by moving their second half down.

const KEPT = 40000;
const OF_THE_REFERENCE = ["wanted_position", "wanted_effort", "error"]; // made here, not sent
const MADE = ["residual", ...OF_THE_REFERENCE];
const HEARD_LATE = 0.4; // s by which the page may hear late that another program runs
const OUTSIDE = 1; // of the flags: far from all training rows

/** Names of the channels that have a role. */
export const named = (channels, role) => channels.filter(channel => channel.role === role).map(({ name }) => name);

export class Store {
  constructor() {
    this.time = new Float64Array(2 * KEPT);
    this.flags = new Uint32Array(2 * KEPT);
    this.columns = {};
    this.clear();
  }

  clear() {
    this.tracked = "";
    this.size = 0;
    this.moved = 0; // samples that were let go
    this.skipped = 0;
    this.taken = 0;
  }

  /** The server's word on its messages: bytes before the rows, and the columns of a row in their order; and on the channels. */
  set({ head, columns }, channels) {
    this.head = head;
    this.words = columns.length;
    this.effort = named(channels, "effort")[0];
    this.position = named(channels, "position").at(-1);
    this.place = Object.fromEntries(columns.map((name, k) => [name, k]));
    this.sent = columns.filter(name => !["time", "flags", "events"].includes(name));
    for (const name of [...this.sent, ...MADE]) this.columns[name] ??= new Float32Array(2 * KEPT);
  }

  /** What the program that runs tracks: "position", "effort" or "". The page hears of it a little late: till then nothing is drawn. */
  set reference(tracked) {
    if (tracked === this.tracked) return;
    for (let row = this.row(this.now - HEARD_LATE); row < this.size; row++) {
      for (const name of OF_THE_REFERENCE) this.columns[name][row] = NaN;
    }
    this.tracked = tracked;
  }

  /** Takes a binary message of the server, see page/wire.py. */
  push(buffer, period) {
    const view = new DataView(buffer);
    this.skipped = view.getUint32(4, true);
    const first = view.getFloat64(8, true); // s, time of the first row
    const count = (buffer.byteLength - this.head) / (4 * this.words);
    const numbers = new Float32Array(buffer, this.head);
    const bits = new Uint32Array(buffer, this.head);

    const missing = this.size && first > this.now + 2.5 * period;
    if (missing) this.#gap(this.now + period);
    this.#room(count);
    for (let k = 0; k < count; k++) {
      const at = k * this.words;
      const row = this.size + k;
      this.time[row] = first + numbers[at + this.place.time];
      this.flags[row] = bits[at + this.place.flags];
      for (const name of this.sent) this.columns[name][row] = numbers[at + this.place[name]];
      this.#make(row, name => numbers[at + this.place[name]]);
    }
    this.size += count;
    this.taken += count;
  }

  /** The columns of a row that follow from those that were sent. */
  #make(row, sent) {
    const { columns, tracked } = this;
    const effort = sent(this.effort);
    const wanted = sent("reference");
    columns.residual[row] = effort - sent("estimate");
    columns.wanted_position[row] = NaN;
    columns.wanted_effort[row] = NaN;
    columns.error[row] = NaN;
    if (tracked === "position") {
      columns.wanted_position[row] = wanted;
      columns.error[row] = wanted - sent(this.position);
    } else if (tracked === "effort") {
      columns.wanted_effort[row] = wanted;
      columns.error[row] = wanted - effort;
    }
  }

  /** A row without numbers, so that no line is drawn over frames that are missing. */
  #gap(time) {
    this.#room(1);
    this.time[this.size] = time;
    this.flags[this.size] = 0;
    for (const column of Object.values(this.columns)) column[this.size] = NaN;
    this.size += 1;
  }

  #room(count) {
    if (this.size + count <= 2 * KEPT) return;
    const drop = this.size - KEPT;
    for (const array of [this.time, this.flags, ...Object.values(this.columns)]) array.copyWithin(0, drop, this.size);
    this.size = KEPT;
    this.moved += drop;
  }

  /** Time of the newest sample [s]. */
  get now() { return this.size ? this.time[this.size - 1] : 0; }

  /** Row of the first sample at or after a time. */
  row(time) {
    let low = 0;
    let high = this.size;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (this.time[middle] < time) low = middle + 1;
      else high = middle;
    }
    return low;
  }

  last(name) { return this.size && this.columns[name] ? this.columns[name][this.size - 1] : NaN; }

  /**
   * Lowest and highest of each stretch of samples, so that no peak is lost in a narrow chart; and the spans outside of the
   * training rows, as [from, to, from, to, ...]. Stretches are counted from the first sample ever, so that a curve does not
   * shimmer while it moves.
   */
  decimate(names, from, to, width) {
    const begin = Math.max(0, this.row(from) - 1);
    const end = Math.min(this.size, this.row(to) + 1);
    const each = Math.max(1, Math.ceil((end - begin) / Math.max(1, width)));
    const columns = names.map(name => this.columns[name]);
    const times = [];
    const lines = names.map(() => []);
    const outside = [];
    for (let start = begin - ((begin + this.moved) % each); start < end; start += each) {
      const first = Math.max(begin, start);
      const stop = Math.min(end, start + each);
      if (first >= stop) continue;
      times.push(this.time[first]);
      if (each > 1) times.push(this.time[stop - 1]);
      columns.forEach((column, k) => {
        if (each > 1) lines[k].push(...extremes(column, first, stop));
        else lines[k].push(Number.isFinite(column[first]) ? column[first] : null);
      });
      if (this.#anyOutside(first, stop)) outside.push(this.time[first], this.time[stop - 1]);
    }
    return { data: [times, ...lines], outside };
  }

  #anyOutside(first, stop) {
    for (let row = first; row < stop; row++) if (this.flags[row] & OUTSIDE) return true;
    return false;
  }

  /** Root mean square of the last second of a column. */
  rms(name) {
    const column = this.columns[name];
    let sum = 0;
    let count = 0;
    for (let row = this.row(this.now - 1); row < this.size; row++) {
      if (Number.isNaN(column[row])) continue;
      sum += column[row] * column[row];
      count += 1;
    }
    return count ? Math.sqrt(sum / count) : NaN;
  }

  /** Share of samples far from training rows over the last second; flags of the newest. */
  lastSecond() {
    const first = this.row(this.now - 1);
    let outside = 0;
    for (let row = first; row < this.size; row++) outside += this.flags[row] & OUTSIDE;
    const samples = this.size - first;
    return {
      outside: samples ? outside / samples : 0,
      flags: this.size ? this.flags[this.size - 1] : 0,
    };
  }
}

/** Smallest and largest value over rows [first, stop), in the order in which they came; two nulls where there is none. */
function extremes(column, first, stop) {
  let least = Infinity;
  let most = -Infinity;
  let leastAt = first;
  let mostAt = first;
  for (let row = first; row < stop; row++) {
    const value = column[row];
    if (value < least) {
      least = value;
      leastAt = row;
    }
    if (value > most) {
      most = value;
      mostAt = row;
    }
  }
  if (least === Infinity) return [null, null];
  return leastAt <= mostAt ? [least, most] : [most, least];
}
