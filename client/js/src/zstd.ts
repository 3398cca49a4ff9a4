// SPDX-License-Identifier: Apache-2.0
// Zstandard, which the platform or the application brings.

/** An implementation of Zstandard (RFC 8878). */
export interface Zstd {
  /** One frame, whose header tells the size of the content. */
  compress(data: Uint8Array): Uint8Array;
  /** The content of one frame. It is called only with frames that declare `size` bytes. */
  decompress(frame: Uint8Array, size: number): Uint8Array;
}

let installed: Zstd | undefined;

/**
 * Says what compresses and decompresses from now on. Node 22.15 or later has Zstandard, and needs no call; elsewhere a
 * package such as @bokuweb/zstd-wasm does.
 */
export function useZstd(zstd: Zstd | undefined): void {
  installed = zstd;
}

/** Whether the codecs that compress can be used. */
export function hasZstd(): boolean {
  return installed !== undefined;
}

/** Error, which says what needs it, if there is no Zstandard. */
export function neededZstd(what: string): Zstd {
  if (installed === undefined) {
    throw new Error(`${what} needs Zstandard: Node 22.15 or later has it, and useZstd() takes any other implementation`);
  }
  return installed;
}

const MAGIC = 0xfd2fb528;

/** The size of the content that a frame declares. RangeError if it is no frame, or declares none. */
function declaredSize(frame: Uint8Array): number {
  const view = new DataView(frame.buffer, frame.byteOffset, frame.byteLength);
  if (frame.length < 6 || view.getUint32(0, true) !== MAGIC) throw new RangeError('it is no frame of Zstandard');
  const descriptor = view.getUint8(4);
  const isSingleSegment = (descriptor >> 5 & 1) === 1;
  const sizeFlag = descriptor >> 6;
  const begin = 5 + (isSingleSegment ? 0 : 1) + [0, 1, 2, 4][descriptor & 3];
  const width = sizeFlag === 0 ? (isSingleSegment ? 1 : 0) : 1 << sizeFlag;
  if (width === 0) throw new RangeError('the frame does not declare its size');
  if (frame.length < begin + width) throw new RangeError('the frame is truncated');
  if (width === 1) return view.getUint8(begin);
  if (width === 2) return view.getUint16(begin, true) + 256;
  return width === 4 ? view.getUint32(begin, true) : Number(view.getBigUint64(begin, true));
}

/** The `size` bytes of one frame that came from a server. RangeError if it is none, or has another size. */
export function decompressed(frame: Uint8Array, size: number, what: string): Uint8Array {
  const zstd = neededZstd(`${what}, which is compressed,`);
  const declared = declaredSize(frame);
  if (declared !== size) throw new RangeError(`the frame declares ${declared} bytes, not the claimed ${size}`);
  let content: Uint8Array;
  try {
    content = zstd.decompress(frame, size);
  } catch (error) {
    throw new RangeError(error instanceof Error ? error.message : String(error));
  }
  if (content.length !== size) throw new RangeError(`the frame decodes to ${content.length} bytes, not the claimed ${size}`);
  return content;
}
