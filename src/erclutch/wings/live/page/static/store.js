// The samples of the last minute, in typed arrays that wrap by moving their second half down.

const KEPT = 40000;
const MADE = ["residual", "wanted_position", "wanted_effort", "error"];

// Names of the channels that have a role.
export const named = (channels, role) => channels.filter(channel => channel.role === role).map(({ name }) => name);

export class Store {
  constructor() {
    this.time = new Float64Array(2 * KEPT);
    this.flags = new Uint32Array(2 * KEPT);
    this.columns = {};
    this.clear();
  }

  // The server's word on its messages: bytes before the rows, and the columns of a row in their order; and on the channels.
  set({ head, columns }, channels) {
    this.head = head; this.words = columns.length;
    this.effort = named(channels, "effort")[0]; this.position = named(channels, "position").at(-1);
    this.place = Object.fromEntries(columns.map((name, k) => [name, k]));
    this.sent = columns.filter(name => !["time", "flags", "events"].includes(name));
    for (const name of [...this.sent, ...MADE]) this.columns[name] ??= new Float32Array(2 * KEPT);
  }

  // What the program that runs tracks: "position", "effort" or "". The page hears of it a little late: till then nothing is drawn.
  set reference(tracked) {
    if (tracked === this.tracked) return;
    for (let i = this.row(this.now - 0.4); i < this.size; i++) for (const name of MADE.slice(1)) this.columns[name][i] = NaN;
    this.tracked = tracked;
  }

  clear() { this.tracked = ""; this.size = 0; this.moved = 0; this.skipped = 0; this.seq = -1; this.taken = 0; }

  // A binary message of the server, see page/wire.py.
  push(buffer, period) {
    const view = new DataView(buffer), place = this.place;
    this.skipped = view.getUint32(4, true);
    const first = view.getFloat64(8, true), seq = view.getFloat64(16, true);
    const count = (buffer.byteLength - this.head) / (4 * this.words);
    const numbers = new Float32Array(buffer, this.head), words = new Uint32Array(buffer, this.head);
    const last = this.size ? this.time[this.size - 1] : -Infinity;
    if (this.size && first > last + 2.5 * period) this.#row(last + period);
    this.#room(count);
    for (let i = 0; i < count; i++) {
      const at = i * this.words, to = this.size + i;
      this.time[to] = first + numbers[at + place.time];
      for (const name of this.sent) this.columns[name][to] = numbers[at + place[name]];
      const wanted = numbers[at + place.reference], effort = numbers[at + place[this.effort]];
      const moves = this.tracked === "position", pulls = this.tracked === "effort";
      this.columns.residual[to] = effort - numbers[at + place.estimate];
      this.columns.wanted_position[to] = moves ? wanted : NaN; this.columns.wanted_effort[to] = pulls ? wanted : NaN;
      this.columns.error[to] = moves ? wanted - numbers[at + place[this.position]] : pulls ? wanted - effort : NaN;
      this.flags[to] = words[at + place.flags];
    }
    this.size += count; this.taken += count; this.seq = seq + count - 1;
  }

  // A row without numbers, so that no line is drawn over frames that are missing.
  #row(time) {
    this.#room(1);
    this.time[this.size] = time; this.flags[this.size] = 0;
    for (const name in this.columns) this.columns[name][this.size] = NaN;
    this.size += 1;
  }

  #room(count) {
    if (this.size + count <= 2 * KEPT) return;
    const drop = this.size - KEPT;
    for (const array of [this.time, this.flags, ...Object.values(this.columns)]) array.copyWithin(0, drop, this.size);
    this.size = KEPT; this.moved += drop;
  }

  get now() { return this.size ? this.time[this.size - 1] : 0; }

  // Row of the first sample at or after a time.
  row(time) {
    let low = 0, high = this.size;
    while (low < high) { const middle = (low + high) >> 1; if (this.time[middle] < time) low = middle + 1; else high = middle; }
    return low;
  }

  last(name) { return this.size && this.columns[name] ? this.columns[name][this.size - 1] : NaN; }

  // Lowest and highest of each stretch of samples, so that no peak is lost in a narrow chart. Stretches are counted
  // from the first sample ever, so that a curve does not shimmer while it moves.
  decimate(names, from, to, width) {
    const a = Math.max(0, this.row(from) - 1), b = Math.min(this.size, this.row(to) + 1), n = b - a;
    const each = Math.max(1, Math.ceil(n / Math.max(1, width)));
    const times = [], lines = names.map(() => []), outside = [];
    for (let start = a - ((a + this.moved) % each); start < b; start += each) {
      const low = Math.max(a, start), high = Math.min(b, start + each);
      if (low >= high) continue;
      const pair = each > 1;
      times.push(this.time[low]); if (pair) times.push(this.time[high - 1]);
      for (let k = 0; k < names.length; k++) {
        const column = this.columns[names[k]];
        let least = Infinity, most = -Infinity, leastAt = low, mostAt = low;
        for (let i = low; i < high; i++) {
          const value = column[i];
          if (value < least) { least = value; leastAt = i; }
          if (value > most) { most = value; mostAt = i; }
        }
        if (least === Infinity) { least = null; most = null; }
        if (pair) lines[k].push(leastAt <= mostAt ? least : most, leastAt <= mostAt ? most : least);
        else lines[k].push(least);
      }
      let out = 0;
      for (let i = low; i < high; i++) out |= this.flags[i] & 1;
      if (out) outside.push(this.time[low], this.time[high - 1]);
    }
    return { data: [times, ...lines], outside };
  }

  // Root mean square of the last second of a column.
  rms(name) {
    let sum = 0, count = 0;
    for (let i = this.row(this.now - 1); i < this.size; i++) {
      const value = this.columns[name][i];
      if (value === value) { sum += value * value; count += 1; }
    }
    return count ? Math.sqrt(sum / count) : NaN;
  }

  // Share of samples far from training rows over the last second; flags of the newest.
  lastSecond() {
    const a = this.row(this.now - 1);
    let outside = 0;
    for (let i = a; i < this.size; i++) outside += this.flags[i] & 1;
    return { outside: this.size > a ? outside / (this.size - a) : 0, flags: this.size ? this.flags[this.size - 1] : 0 };
  }
}
