// SPDX-License-Identifier: Apache-2.0

/** The time from sending a frame to its outcome, learned as TCP learns its timeout (RFC 6298, section 2). Milliseconds. */
export class ServiceTime {
  #mean: number | undefined;
  #deviation = 0;

  /** A frame took so long. */
  add(took: number): void {
    if (this.#mean === undefined) {
      this.#mean = took;
      this.#deviation = took / 2;
      return;
    }
    const off = took - this.#mean;
    this.#deviation += (Math.abs(off) - this.#deviation) / 4;
    this.#mean += off / 8;
  }

  /** A frame took at least so long, and was given up then. */
  addAtLeast(time: number): void {
    if (this.#mean === undefined || time > this.#mean) this.add(time);
  }

  /** A time that few frames exceed; 0 if none has come yet. */
  bound(): number {
    return this.#mean === undefined ? 0 : this.#mean + 4 * this.#deviation;
  }
}
