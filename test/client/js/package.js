// SPDX-License-Identifier: Apache-2.0
// Modules of the package that was built, and of the packages beside it. JS_PACKAGE is the folder of the package.
import {createRequire} from 'node:module';
import path from 'node:path';
import {pathToFileURL} from 'node:url';

const folder = process.env.JS_PACKAGE ?? fail();

function fail() {
  throw new Error('JS_PACKAGE must be the folder of the package that was built of client/js');
}

/** A module of ours, such as "stream/protocol". */
export function ours(name) {
  return import(pathToFileURL(path.join(folder, 'dist', `${name}.js`)));
}

const require = createRequire(path.join(folder, 'package.json'));

/** A module of a package of npm. */
export function theirs(name) {
  return import(pathToFileURL(require.resolve(name)));
}

/** Zstandard for Nodes that have none. */
export async function useZstd() {
  const {hasZstd, useZstd: use} = await ours('zstd');
  if (hasZstd()) return;
  const {compress, decompress, init} = (await theirs('@bokuweb/zstd-wasm')).default;
  await init();
  use({compress: (data) => compress(data, 1), decompress: (frame) => decompress(frame)});
}
