"use strict";
// Rows as the report packs them: differences of int16 in two planes, deflated; in layers of ever longer buckets.

/** The int16 values of a layer. The planes hold the low and the high byte of each difference, zigzag: 0, -1, 1, -2, ... */
async function unpack(text) {
  const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate-raw"));
  const planes = new Uint8Array(await new Response(stream).arrayBuffer());
  const length = planes.length / 2;
  const values = new Int16Array(length);
  let value = 0;
  for (let k = 0; k < length; k++) {
    const zigzag = planes[k] | (planes[length + k] << 8);
    const difference = (zigzag >> 1) ^ -(zigzag & 1);
    value = ((value + difference) << 16) >> 16; // wraps as int16 does
    values[k] = value;
  }
  return values;
}

/** A signal or an estimate: `middle + step * value` of each row, or the smallest and largest of each bucket of rows. */
class Channel {
  constructor({ step, middle, layers }) {
    this.step = step;
    this.middle = middle;
    this.layers = layers.map(([start, stop, bucket, data]) => ({ start, stop, bucket, data, values: null, wait: null }));
  }

  /** The finest layer that holds rows [first, stop). */
  pick(first, stop) {
    const holding = this.layers.filter((layer) => layer.start <= first && layer.stop >= stop);
    if (!holding.length) return this.layers[0];
    return holding.reduce((finest, layer) => (layer.bucket < finest.bucket ? layer : finest));
  }

  /** Null where the rows can be read; otherwise a promise of that. */
  ready(first, stop) {
    const layer = this.pick(first, stop);
    if (layer.values) return null;
    layer.wait ||= unpack(layer.data).then((values) => {
      layer.values = values;
      layer.data = null;
    });
    return layer.wait;
  }

  value(packed) { return packed * this.step + this.middle; }

  /** Smallest and largest of rows [first, stop). */
  range(layer, first, stop) {
    const each = layer.bucket > 1 ? 2 : 1; // values a bucket
    const placeOf = (row) => each * Math.floor((row - layer.start) / layer.bucket);
    let low = 32767;
    let high = -32768;
    for (let k = placeOf(first); k < placeOf(stop - 1) + each; k++) {
      const value = layer.values[k];
      if (value < low) low = value;
      if (value > high) high = value;
    }
    return [this.value(low), this.value(high)];
  }
}
