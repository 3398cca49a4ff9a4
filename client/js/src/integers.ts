// SPDX-License-Identifier: Apache-2.0
// Arrays of answers, of which nothing is believed.
import {type Block, Compression} from './gen/segserve/v1/block_pb.js';
import {type IntegerArray} from './gen/segserve/v1/result_pb.js';
import {decompressed} from './zstd.js';

/** The `expected` bytes of a block. RangeError if it has others. */
export function blockBytes(block: Block | undefined, expected: number, name: string): Uint8Array {
  if (block === undefined) throw new RangeError(`${name}: it has no data`);
  const {compression, data, encodedBytes, decodedBytes} = block;
  if (encodedBytes !== 0n && encodedBytes !== BigInt(data.length)) {
    throw new RangeError(`${name}: claims ${encodedBytes} encoded bytes, but has ${data.length}`);
  }
  const isCompressed = compression === Compression.ZSTD;
  if ((isCompressed || decodedBytes !== 0n) && decodedBytes !== BigInt(expected)) {
    throw new RangeError(`${name}: claims ${decodedBytes} bytes, but must have ${expected}`);
  }
  if (isCompressed) return decompressed(data, expected, name);
  if (compression !== Compression.UNSPECIFIED && compression !== Compression.NONE) {
    throw new RangeError(`${name}: compression ${compression} is unknown`);
  }
  if (data.length !== expected) throw new RangeError(`${name}: has ${data.length} bytes, but must have ${expected}`);
  return data;
}

/** The values of an array. RangeError unless there are `count`, none above `largest`. */
export function integers(message: IntegerArray | undefined, count: number, largest: number, name: string): Uint32Array {
  if (message === undefined) throw new RangeError(`${name}: it is missing`);
  const width = message.bytesPerValue;
  if (message.count !== BigInt(count)) {
    throw new RangeError(`${name}: has ${message.count} values, but must have ${count}`);
  }
  if (width !== 1 && width !== 2 && width !== 4) {
    throw new RangeError(`${name}: has ${width} bytes per value, but must have 1, 2 or 4`);
  }
  const bytes = blockBytes(message.data, count * width, name);
  const values = widened(bytes, count, width);
  let most = 0;
  for (let i = 0; i < count; ++i) most = Math.max(most, values[i]);
  if (most > largest) throw new RangeError(`${name}: holds ${most}, but the largest allowed value is ${largest}`);
  return values;
}

function widened(bytes: Uint8Array, count: number, width: 1 | 2 | 4): Uint32Array {
  const values = new Uint32Array(count);
  if (width === 1) {
    values.set(bytes);
    return values;
  }
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  for (let i = 0; i < count; ++i) values[i] = width === 2 ? view.getUint16(2 * i, true) : view.getUint32(4 * i, true);
  return values;
}
