// SPDX-License-Identifier: Apache-2.0
// Does with the package of client/js what a test asks for.
//
//   node js_client.mjs PACKAGE TASK ADDRESS FOLDER [OPTIONS]
//
// PACKAGE is the folder of the package. FOLDER holds a cloud: `xyz.f32`, `rgb.u8` and `shape` with its columns and rows. OPTIONS
// is a JSON object. Labels are written to FOLDER as little-endian integers of 4 bytes. Lines of JSON go to the standard output.
import {createRequire} from 'node:module';
import fs from 'node:fs';
import path from 'node:path';
import {pathToFileURL} from 'node:url';

const [folderOfPackage, task, address, folder, text = '{}'] = process.argv.slice(2);
const options = JSON.parse(text);
const isWeb = options.web === true;
const segserve = await import(pathToFileURL(path.join(folderOfPackage, 'dist', isWeb ? 'web.js' : 'index.js')));

const read = (name) => fs.readFileSync(path.join(folder, name));
const [width, height] = read('shape').toString().split(' ').map(Number);
const floats = (bytes) => new Float32Array(bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.length));
const cloud = {xyz: floats(read('xyz.f32')), rgb: new Uint8Array(read('rgb.u8')), width, height};

function say(value) {
  console.log(JSON.stringify(value));
}

function write(name, labels) {
  const bytes = Buffer.alloc(4 * labels.length);
  labels.forEach((label, i) => bytes.writeUInt32LE(label, 4 * i));
  fs.writeFileSync(path.join(folder, `${name}.u32`), bytes);
}

async function useZstd() {
  if (segserve.hasZstd()) return;
  const zstd = createRequire(path.join(folderOfPackage, 'package.json'))('@bokuweb/zstd-wasm');
  await zstd.init();
  segserve.useZstd({compress: (data) => zstd.compress(data, 1), decompress: (frame) => zstd.decompress(frame)});
}

/** What a call means besides the cloud: a file, images, or arrays of another type. */
function inputOf({file, images, plain, ...rest}) {
  if (file !== undefined) return {pcd: new Uint8Array(fs.readFileSync(file)), ...rest};
  if (images === 'files') return {depth: new Uint8Array(read('depth.png')), color: new Uint8Array(read('color.png')), ...rest};
  if (images === 'pixels') {
    const depth = Uint16Array.from({length: width * height}, (_, i) => Math.round(1000 * (cloud.xyz[3 * i + 2] || 0)));
    return {depth: {width, height, data: depth}, color: {width, height, data: cloud.rgb}, ...rest};
  }
  if (plain === undefined) return {...cloud, ...rest};
  const finite = [];
  for (let i = 0; i < cloud.xyz.length; i += 3) {
    if (Number.isFinite(cloud.xyz[i])) finite.push(...cloud.xyz.subarray(i, i + 3));
  }
  return {xyz: plain === 'double' ? Float64Array.from(finite) : Float32Array.from(finite), ...rest};
}

const client = new segserve.Client(address, options.client);

const TASKS = {
  /** Segments once for each name of `calls`. */
  async segment() {
    for (const [name, call] of Object.entries(options.calls)) {
      const result = await client.segment(inputOf(call));
      write(name, result.labels);
      if (result.selection?.labels !== undefined) write(`${name}-selected`, result.selection.labels);
      say({...result, name, labels: result.labels.length, supervoxels: undefined, tree: undefined});
    }
  },

  /** Makes every cut and selection of one result. */
  async cut() {
    const result = await client.segment({...cloud, view: 'camera'});
    for (const [name, cut] of Object.entries(options.cuts)) {
      write(name, result.cut(cut));
      write(`${name}-again`, (await client.segment({...cloud, view: 'camera', ...cut})).labels);
    }
    for (const [name, places] of Object.entries(options.picks)) {
      const {labels, ...picked} = result.select(places);
      write(name, labels);
      say({name, ...picked});
    }
  },

  /** Streams frames, and prints the end of each. */
  async stream() {
    const rules = {view: 'camera', ...options.rules};
    const stream = client.stream(rules);
    const frames = async function* () {
      const end = performance.now() + (options.seconds ?? 60) * 1000;
      for (let i = 0; i < options.frames && performance.now() < end; ++i) yield {...cloud, ...options.each};
    };
    for await (const {sequence, kind, result, error, report} of stream.map(frames())) {
      if (result !== undefined && (sequence === 1 || options.seconds === undefined)) write(`frame-${sequence}`, result.labels);
      say({sequence, kind, error: error?.message, attempts: report.attempts, address: report.address,
           selected: result?.selection?.labels?.reduce((sum, label) => sum + label, 0)});
    }
    await stream.close();
  },

  /** Sends three frames of different kinds, and cancels a fourth. */
  async outcomes() {
    await useZstd();
    const stream = client.stream({view: 'camera', outputs: ['labels'], maxInFlight: 1, maxWaiting: 9, order: 'done', ...options.rules});
    await stream.send({...cloud, requestId: 'a', frameId: 'camera', timeToLiveMs: 20_000});
    await stream.send({...cloud, regions: 5, outputs: ['labels', 'tree']});
    await stream.send({...cloud, options: {voxelResolution: 100}});
    stream.cancel(await stream.send(cloud));
    stream.finish();
    for await (const {sequence, kind, requestId, frameId, result, error} of stream) {
      if (sequence === 1) write('first', result.labels);
      say({sequence, kind, requestId, frameId, segments: result?.segmentCount, hasTree: result?.tree !== undefined,
           reason: error?.reason, fields: error?.fieldViolations.map(({field}) => field)});
    }
  },

  /** The error of each call. */
  async errors() {
    for (const call of options.calls) {
      const error = await (call.service === undefined ? client.segment(inputOf(call)) : client.health(call.service, call.options))
                        .then(() => ({message: 'it succeeded'}), (failure) => failure);
      const {name, code, reason, message, fieldViolations} = error;
      say({name, code, reason, message, fields: fieldViolations?.map(({field}) => field)});
    }
  },

  async info() {
    say({...await client.info(), healthy: await client.health?.(), methodNames: segserve.METHODS});
  },
};

if (Object.values(options.calls ?? {}).some(({codec}) => codec?.includes('zstd') || codec === 'quantised')) await useZstd();
await TASKS[task]();
await client.close?.();
