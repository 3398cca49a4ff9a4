// SPDX-License-Identifier: Apache-2.0
// Payloads as messages of a few hundred kilobytes.

/** The bytes of a payload that are still to be sent. */
export class OutgoingBytes {
  readonly #blocks: Uint8Array[];

  constructor(blocks: readonly Uint8Array[]) {
    this.#blocks = blocks.filter(({length}) => length > 0);
  }

  isDone(): boolean {
    return this.#blocks.length === 0;
  }

  /** The next bytes, at most `most`, and at least one. There must be some. */
  take(most: number): Uint8Array {
    const block = this.#blocks[0];
    if (block.length > most) this.#blocks[0] = block.subarray(most);
    else this.#blocks.shift();
    return block.subarray(0, most);
  }
}

const LENGTH_DELIMITED = 2;
const CHUNK_TAG = 3 << 3 | LENGTH_DELIMITED;  // SegmentStreamRequest.chunk
const SEQUENCE_TAG = 1 << 3;                  // FrameChunk.sequence
const DATA_TAG = 2 << 3 | LENGTH_DELIMITED;   // FrameChunk.data

function varint(value: number): number[] {
  const bytes: number[] = [];
  let rest = value;
  for (; rest >= 0x80; rest = Math.floor(rest / 0x80)) bytes.push(rest % 0x80 + 0x80);
  bytes.push(rest);
  return bytes;
}

/** A serialized SegmentStreamRequest with a FrameChunk. The protobuf library would copy the data three times. */
export function chunkMessage(number: number, data: Uint8Array): Uint8Array {
  const inner = [SEQUENCE_TAG, ...varint(number), DATA_TAG, ...varint(data.length)];
  const head = [CHUNK_TAG, ...varint(inner.length + data.length), ...inner];
  const message = new Uint8Array(head.length + data.length);
  message.set(head);
  message.set(data, head.length);
  return message;
}
