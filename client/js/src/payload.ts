// SPDX-License-Identifier: Apache-2.0
// A cloud as it goes over the wire.
import {clone, create} from '@bufbuild/protobuf';

import {crc32} from './crc32.js';
import {type Block, BlockSchema, Compression} from './gen/segserve/v1/block_pb.js';
import {type Cloud, CloudSchema} from './gen/segserve/v1/cloud_pb.js';
import {type Zstd} from './zstd.js';

/**
 * A cloud that is encoded once and sent any number of times; `encode` makes it. The arrays that it was made of may change
 * afterwards.
 */
export class Payload {
  /** The size of all blocks, bytes. */
  readonly size: number;
  #crc32: number | undefined;

  /** @internal */
  constructor(
      /** The cloud without the bytes of its blocks. */
      readonly header: Cloud,
      /** The bytes of the blocks, in the order in which cloud.proto declares them. */
      readonly blocks: readonly Uint8Array[],
      /** The number of points; undefined if only the server knows it. */
      readonly points?: number,
      /** The size of the cloud after decompression, bytes; 0 if only the server knows it. */
      readonly decodedBytes = 0,
      /** Whether the answer may be compressed, too. */
      readonly compressed = false) {
    this.size = blocks.reduce((sum, block) => sum + block.length, 0);
  }

  /** The columns and rows of an organized cloud, and of the labels; undefined if only the server knows them. */
  get shape(): {readonly width?: number, readonly height?: number} {
    const {width, height} = this.header;
    return width > 0 && height > 0 ? {width, height} : {};
  }

  /** The CRC-32 of all blocks, one after the other. */
  get crc32(): number {
    this.#crc32 ??= this.blocks.reduce((crc, block) => crc32(block, crc), 0);
    return this.#crc32;
  }

  /** The cloud with the bytes of its blocks. @internal */
  message(): Cloud {
    const message = clone(CloudSchema, this.header);
    blocksOf(message).forEach((block, i) => { block.data = this.blocks[i]; });
    return message;
  }
}

/** The blocks that a cloud has, in the order in which they are sent. */
function blocksOf({payload}: Cloud): Block[] {
  switch (payload.case) {
    case 'planar':
      return present(payload.value.x, payload.value.y, payload.value.z, payload.value.rgb);
    case 'pcdFile':
      return present(payload.value.file);
    case 'strided':
    case 'quantised':
      return present(payload.value.data);
    case 'rgbd':
      return present(payload.value.depth, payload.value.color);
    default:
      throw new TypeError(`there is no codec for the payload ${payload.case}`);
  }
}

function present(...blocks: (Block | undefined)[]): Block[] {
  return blocks.filter((block): block is Block => block !== undefined);
}

/** Collects the blocks of a payload. */
export class BlockList {
  readonly bytes: Uint8Array[] = [];

  /** `zstd`: compresses blocks that become smaller by it. */
  constructor(private readonly zstd?: Zstd) {}

  /** The description of a block whose bytes will follow. */
  add(data: Uint8Array): Block {
    const compressed = this.zstd?.compress(data);
    const isSmaller = compressed !== undefined && compressed.length < data.length;
    const encoded = isSmaller ? compressed : data;
    this.bytes.push(encoded);
    return create(BlockSchema, {
      compression: isSmaller ? Compression.ZSTD : Compression.NONE,
      decodedBytes: BigInt(data.length),
      encodedBytes: BigInt(encoded.length),
    });
  }
}
