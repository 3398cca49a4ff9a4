// SPDX-License-Identifier: Apache-2.0
// The CRC-32 of zlib, PNG and RFC 1952.

/** The checksum of bytes, continued from that of the bytes before them. */
export type Crc32 = (bytes: Uint8Array, before?: number) => number;

const TABLES = makeTables();
let implementation: Crc32 = crc32ByTables;

/** Says what computes checksums from now on. */
export function useCrc32(faster: Crc32): void {
  implementation = faster;
}

/** The CRC-32 of bytes, continued from that of the bytes before them. */
export function crc32(bytes: Uint8Array, before = 0): number {
  return implementation(bytes, before);
}

/** Eight tables, so that eight bytes are done in one step ("slicing by 8"). */
function makeTables(): Uint32Array[] {
  const tables = Array.from({length: 8}, () => new Uint32Array(256));
  for (let byte = 0; byte < 256; ++byte) {
    let crc = byte;
    for (let bit = 0; bit < 8; ++bit) crc = crc & 1 ? crc >>> 1 ^ 0xedb88320 : crc >>> 1;
    tables[0][byte] = crc;
  }
  for (let byte = 0; byte < 256; ++byte) {
    for (let k = 1; k < 8; ++k) {
      const before = tables[k - 1][byte];
      tables[k][byte] = tables[0][before & 255] ^ before >>> 8;
    }
  }
  return tables;
}

/** The same in JavaScript alone. */
export function crc32ByTables(bytes: Uint8Array, before = 0): number {
  const [t0, t1, t2, t3, t4, t5, t6, t7] = TABLES;
  let crc = ~before;
  let i = 0;
  for (const end = bytes.length - 7; i < end; i += 8) {
    crc ^= bytes[i] | bytes[i + 1] << 8 | bytes[i + 2] << 16 | bytes[i + 3] << 24;
    crc = t7[crc & 255] ^ t6[crc >>> 8 & 255] ^ t5[crc >>> 16 & 255] ^ t4[crc >>> 24] ^ t3[bytes[i + 4]] ^
          t2[bytes[i + 5]] ^ t1[bytes[i + 6]] ^ t0[bytes[i + 7]];
  }
  for (; i < bytes.length; ++i) crc = t0[(crc ^ bytes[i]) & 255] ^ crc >>> 8;
  return ~crc >>> 0;
}
