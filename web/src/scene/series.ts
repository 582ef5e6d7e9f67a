/** Samples of signals over time, of the last `kSpan` seconds; bounded however fast they come. */

const kCapacity = 4096;
export const kSpan = 30; // s

/** One signal. Times do not decrease; a sample of an earlier time begins the series anew. */
export class Series {
  readonly times = new Float64Array(kCapacity);
  readonly values = new Float32Array(kCapacity);
  #first = 0;
  #count = 0;

  get length(): number {
    return this.#count;
  }

  /** Place in `times` and `values` of the i-th sample, the oldest is 0. */
  place(i: number): number {
    return (this.#first + i) % kCapacity;
  }

  add(time: number, value: number): void {
    if (!Number.isFinite(time) || !Number.isFinite(value)) return;
    if (this.#count > 0) {
      const last = this.place(this.#count - 1);
      const since = time - this.times[last]!;
      if (since < 0) {
        this.#count = 0;
      } else if (since < kSpan / kCapacity) {
        // Faster than the chart can show: the larger one stays, a peak is not lost.
        if (Math.abs(value) >= Math.abs(this.values[last]!)) this.values[last] = value;
        return;
      }
    }
    if (this.#count === kCapacity) {
      this.#first = (this.#first + 1) % kCapacity;
      this.#count--;
    }
    const at = this.place(this.#count++);
    this.times[at] = time;
    this.values[at] = value;
  }

  last(): number | undefined {
    return this.#count === 0 ? undefined : this.values[this.place(this.#count - 1)];
  }
}
