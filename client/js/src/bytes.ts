// SPDX-License-Identifier: Apache-2.0
// Numbers as bytes and back. The wire is little endian, as all but a few machines are.

const IS_LITTLE_ENDIAN = new Uint8Array(new Uint16Array([1]).buffer)[0] === 1;

/** The bytes of an array, little endian. They share its memory. */
export function bytesOf(array: Float32Array | Float64Array | Uint32Array): Uint8Array {
  const bytes = new Uint8Array(array.buffer, array.byteOffset, array.byteLength);
  if (!IS_LITTLE_ENDIAN) swap(bytes, array.BYTES_PER_ELEMENT);
  return bytes;
}

/** The little-endian doubles in bytes, as a copy. */
export function float64Of(bytes: Uint8Array): Float64Array {
  const copy = new Uint8Array(bytes);  // slice() of a Buffer would share its memory
  if (!IS_LITTLE_ENDIAN) swap(copy, 8);
  return new Float64Array(copy.buffer, copy.byteOffset, copy.length / 8);
}

function swap(bytes: Uint8Array, width: number): void {
  for (let begin = 0; begin < bytes.length; begin += width) bytes.subarray(begin, begin + width).reverse();
}

const FIRST_CAPACITY = 64 << 10;

/** Bytes that arrive in parts, of which no more are held than twice those that have come. */
export class ArrivingBytes {
  #bytes = new Uint8Array(0);
  #length = 0;

  /** `expected`: how many will come. */
  constructor(readonly expected: number) {}

  get missing(): number {
    return this.expected - this.#length;
  }

  /** At most those that are missing. */
  add(part: Uint8Array): void {
    const length = this.#length + part.length;
    if (length > this.#bytes.length) {
      const larger = new Uint8Array(Math.min(this.expected, Math.max(2 * length, FIRST_CAPACITY)));
      larger.set(this.#bytes.subarray(0, this.#length));
      this.#bytes = larger;
    }
    this.#bytes.set(part, this.#length);
    this.#length = length;
  }

  /** Those that have come. */
  get bytes(): Uint8Array {
    return this.#bytes.subarray(0, this.#length);
  }
}

/** One after the other. */
export function concatenated(parts: readonly Uint8Array[]): Uint8Array {
  const whole = new Uint8Array(parts.reduce((sum, part) => sum + part.length, 0));
  let begin = 0;
  for (const part of parts) {
    whole.set(part, begin);
    begin += part.length;
  }
  return whole;
}
