// SPDX-License-Identifier: Apache-2.0
// The client's side of the protocol in stream.proto, on one connection.
import {create, toBinary} from '@bufbuild/protobuf';

import {ArrivingBytes} from '../bytes.js';
import {crc32} from '../crc32.js';
import {SegserveError} from '../errors.js';
import {type Block} from '../gen/segserve/v1/block_pb.js';
import {type SegmentationResult} from '../gen/segserve/v1/result_pb.js';
import {DrainReason, FrameCancelSchema, type FrameHeader, type FrameOutcome, type ResultChunk, type SegmentStreamRequest,
        SegmentStreamRequestSchema, type SegmentStreamResponse, type StreamOpen,
        type StreamOpened} from '../gen/segserve/v1/stream_pb.js';
import {type Payload} from '../payload.js';
import {chunkMessage, OutgoingBytes} from './chunks.js';

const MOST_CHUNK_BYTES = 256 << 10;
const MOST_POINTS = 100_000_000;  // that are allowed if their number is not known

/** Whether the credit in bytes has room for a frame. */
export type Fit = 'NOW' | 'LATER' | 'NEVER';

/** A message to be sent, serialized. */
export interface Outgoing {
  readonly data: Uint8Array;
  readonly kind: 'open' | 'frame' | 'chunk' | 'cancel';
  /** Of the frame that it is a part of. */
  readonly sequence?: number;
  readonly completesPayload?: boolean;
}

/**
 * The meaning of a message from the server. OLD: the server asks for another stream. BEGUN: the first bytes of an outcome
 * came.
 */
export type Event = {readonly kind: 'NOTHING' | 'OPENED' | 'DRAINING' | 'OLD'} |
                    {readonly kind: 'BEGUN', readonly sequence: number} | OutcomeEvent;

/** An outcome is complete, with the bytes of the result in its blocks. */
export interface OutcomeEvent {
  readonly kind: 'OUTCOME';
  readonly sequence: number;
  readonly outcome: FrameOutcome;
  /** False if the checksum differs from the one that was announced. */
  readonly isIntact: boolean;
}

interface SentFrame {
  readonly sequence: number;
  readonly size: number;
  readonly points?: number;
}

/** A result whose bytes are arriving. */
interface Arrival {
  readonly outcome: FrameOutcome;
  readonly data: ArrivingBytes;
}

/** The blocks of a result, in the order in which their bytes come. */
function resultBlocks(result: SegmentationResult | undefined): Block[] {
  const {labels, supervoxels, tree, selected} = result ?? {};
  return [labels?.data, supervoxels?.data, tree?.leafPoints?.data, tree?.left?.data, tree?.right?.data, tree?.weight,
          selected?.data]
      .filter((block) => block !== undefined);
}

/**
 * The most bytes that the result for a cloud can have. Each point has two labels of 4 bytes, may be a leaf of 20 bytes, and
 * may be selected; zstd and the columns need some slack.
 */
function mostResultBytes(points = MOST_POINTS): number {
  return (64 << 10) + 29 * points;
}

function broken(message: string): SegserveError {
  return new SegserveError('INTERNAL', `the server broke the protocol of the stream: ${message}`);
}

/**
 * Numbers the frames, keeps to the credit, cuts payloads into chunks and joins the chunks of results.
 *
 * Knows neither transport nor clock. Callers name frames by the stream's sequence. On the wire frames have numbers of
 * their own, because a frame may be sent twice on one connection.
 */
export class StreamProtocol {
  #open: StreamOpen | undefined;
  #draining = false;
  #ended = false;
  #creditFrames = 0;
  #chunkBytes = 0;
  #bytesUsed = 0;  // of the credit
  #lastNumber = 0;
  readonly #sent = new Map<number, SentFrame>();  // by number on the wire
  #cancels: number[] = [];                        // numbers on the wire
  #upload = 0;                                    // the number of the frame whose payload is being sent; 0: none
  #header: FrameHeader | undefined;
  #payload = new OutgoingBytes([]);
  #arrival: Arrival | undefined;
  /** The server has granted credit. */
  opened = false;
  /** That the server has granted. */
  creditBytes = 0;

  constructor(open: StreamOpen) {
    this.#open = open;
  }

  /** No new frame may begin: the server is about to stop, or end() was called. */
  get ending(): boolean {
    return this.#draining || this.#ended;
  }

  /** How many frames have no outcome. */
  get inFlight(): number {
    return this.#sent.size;
  }

  /** Whether a frame may begin now, as far as the upload before it and the credit in frames are concerned. */
  hasTurn(): boolean {
    return this.opened && !this.ending && this.#upload === 0 && this.#sent.size < this.#creditFrames;
  }

  /** Whether the credit in bytes has room for so many bytes now, or ever. */
  fit(size: number): Fit {
    if (size > this.creditBytes) return 'NEVER';
    return this.#bytesUsed + size <= this.creditBytes ? 'NOW' : 'LATER';
  }

  /** Begins the next frame. hasTurn() must be true, and the payload must fit. */
  begin(sequence: number, header: FrameHeader, payload: Payload): void {
    this.#lastNumber += 1;
    this.#upload = this.#lastNumber;
    header.sequence = BigInt(this.#upload);
    header.cloud = payload.header;
    header.encodedBytes = BigInt(payload.size);
    header.points = BigInt(payload.points ?? 0);
    header.decodedBytes = BigInt(payload.decodedBytes);
    header.crc32 = payload.crc32;
    this.#header = header;
    this.#bytesUsed += payload.size;
    this.#sent.set(this.#upload, {sequence, size: payload.size, points: payload.points});
    this.#payload = new OutgoingBytes(payload.blocks);
  }

  /** Asks the server to drop the frame; its outcome comes all the same. Unknown frames are left alone. */
  cancel(sequence: number): void {
    for (const [number, frame] of this.#sent) {
      if (frame.sequence === sequence) this.#cancels.push(number);
    }
  }

  /** No more frames will begin. */
  end(): void {
    this.#ended = true;
  }

  /** The message to be sent next; undefined if there is none now. */
  next(): Outgoing | undefined {
    if (this.#open !== undefined) {
      const open = this.#open;
      this.#open = undefined;
      return {data: serialized({case: 'open', value: open}), kind: 'open'};
    }
    if (this.#header !== undefined) return this.#nextHeader(this.#header);  // no cancel may come before its header
    if (this.#cancels.length > 0) return this.#nextCancel();
    return this.#upload === 0 ? undefined : this.#nextChunk();
  }

  #nextHeader(header: FrameHeader): Outgoing {
    this.#header = undefined;
    const {sequence} = this.#sent.get(this.#upload) as SentFrame;
    return {data: serialized({case: 'frame', value: header}), kind: 'frame', sequence, completesPayload: this.#endUpload()};
  }

  #nextCancel(): Outgoing {
    const number = this.#cancels.shift() as number;
    if (this.#upload === number) this.#upload = 0;  // no chunks of the frame may follow
    const value = create(FrameCancelSchema, {sequence: BigInt(number)});
    return {data: serialized({case: 'cancel', value}), kind: 'cancel'};
  }

  #nextChunk(): Outgoing {
    const {sequence} = this.#sent.get(this.#upload) as SentFrame;
    const data = chunkMessage(this.#upload, this.#payload.take(this.#chunkBytes));
    return {data, kind: 'chunk', sequence, completesPayload: this.#endUpload()};
  }

  /** Whether the whole payload was sent, which ends the upload. */
  #endUpload(): boolean {
    if (!this.#payload.isDone()) return false;
    this.#upload = 0;
    return true;
  }

  /** True after end(), once nothing will be sent any more. */
  wantsHalfClose(): boolean {
    return this.ending && this.#open === undefined && this.#upload === 0 && this.#cancels.length === 0;
  }

  /** Takes a message from the server. SegserveError (INTERNAL) if the server broke the protocol; the connection is of no
   * use then. */
  receive({kind}: SegmentStreamResponse): Event {
    if (!this.opened && kind.case !== 'opened') throw broken('its first message was not StreamOpened');
    if (this.#arrival !== undefined && kind.case !== 'chunk') throw broken('another message interrupted the bytes of a result');
    switch (kind.case) {
      case 'opened':
        return this.#receiveOpened(kind.value);
      case 'outcome':
        return this.#receiveOutcome(kind.value);
      case 'chunk':
        return this.#receiveChunk(kind.value);
      case 'draining':
        if (kind.value.reason === DrainReason.STREAM_AGE) return {kind: 'OLD'};
        this.#draining = true;
        return {kind: 'DRAINING'};
      default:
        return {kind: 'NOTHING'};  // a message that a newer version knows
    }
  }

  #receiveOpened({credit, maxChunkBytes}: StreamOpened): Event {
    if (this.opened) throw broken('it opened the stream twice');
    if (!credit?.frames || !credit.bytes || !maxChunkBytes) throw broken('it granted no credit');
    this.opened = true;
    this.#creditFrames = credit.frames;
    this.creditBytes = Number(credit.bytes);
    this.#chunkBytes = Math.min(maxChunkBytes, MOST_CHUNK_BYTES);
    return {kind: 'OPENED'};
  }

  #receiveOutcome(outcome: FrameOutcome): Event {
    const number = Number(outcome.sequence);
    const frame = this.#sent.get(number);
    if (frame === undefined) throw broken(`it ended frame ${outcome.sequence}, which it does not have`);
    if (this.#upload === number) this.#upload = 0;  // the server does not want the rest of the payload
    const announced = Number(outcome.encodedBytes);
    const most = mostResultBytes(frame.points);
    if (announced > most) throw broken(`it announced a result of ${announced} bytes; ${most} are allowed`);
    const promised = resultBlocks(outcome.result).reduce((sum, {encodedBytes}) => sum + encodedBytes, 0n);
    if (promised !== outcome.encodedBytes) {
      throw broken(`it announced a result of ${announced} bytes whose blocks have ${promised}`);
    }
    const arrival = {outcome, data: new ArrivingBytes(announced)};
    if (announced === 0) return this.#complete(arrival);
    this.#arrival = arrival;
    return {kind: 'BEGUN', sequence: frame.sequence};
  }

  #receiveChunk({sequence, data}: ResultChunk): Event {
    const arrival = this.#arrival;
    if (arrival === undefined || sequence !== arrival.outcome.sequence) {
      throw broken('it sent a chunk that belongs to no result');
    }
    const {missing} = arrival.data;
    if (data.length === 0 || data.length > missing) {
      throw broken(`it sent a chunk of ${data.length} bytes where ${missing} were missing`);
    }
    arrival.data.add(data);
    return arrival.data.missing > 0 ? {kind: 'NOTHING'} : this.#complete(arrival);
  }

  #complete({outcome, data: {bytes: data}}: Arrival): Event {
    this.#arrival = undefined;
    let begin = 0;
    for (const block of resultBlocks(outcome.result)) {
      const end = begin + Number(block.encodedBytes);
      block.data = data.subarray(begin, end);
      begin = end;
    }
    const number = Number(outcome.sequence);
    const frame = this.#sent.get(number) as SentFrame;
    this.#sent.delete(number);
    this.#bytesUsed -= frame.size;
    this.#cancels = this.#cancels.filter((cancelled) => cancelled !== number);
    const isIntact = data.length === 0 || crc32(data) === outcome.crc32;
    return {kind: 'OUTCOME', sequence: frame.sequence, outcome, isIntact};
  }
}

function serialized(kind: SegmentStreamRequest['kind']): Uint8Array {
  return toBinary(SegmentStreamRequestSchema, create(SegmentStreamRequestSchema, {kind}));
}
