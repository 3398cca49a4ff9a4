// SPDX-License-Identifier: Apache-2.0
// The functions that Node has itself, and does faster: checksums since 20.15, Zstandard since 22.15.
import zlib from 'node:zlib';

import {useCrc32} from '../crc32.js';
import {useZstd} from '../zstd.js';

const LEVEL = 1;  // saves time on links of 100 Mbit/s and below

if (typeof zlib.crc32 === 'function') useCrc32(zlib.crc32);

if (typeof zlib.zstdCompressSync === 'function') {
  const params = {[zlib.constants.ZSTD_c_compressionLevel]: LEVEL};
  useZstd({
    compress: (data) => zlib.zstdCompressSync(data, {params, pledgedSrcSize: data.length}),
    decompress: (frame, size) => zlib.zstdDecompressSync(frame, {maxOutputLength: size}),
  });
}
