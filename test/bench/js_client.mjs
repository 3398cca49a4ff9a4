#!/usr/bin/env node
// SPDX-License-Identifier: Apache-2.0
// Measures what the JavaScript client adds to the server's time, and prints tables for client/js/README.md.
//
//   test/bench/js_client.mjs [--build build/release] [--seconds 5] [--rounds 3] [FILE]
//
// FILE is an organized cloud with colors in the frame of a camera; the default is a synthetic frame of 640 x 480. The tables are those of python_client.py: single calls, with medians of the time to encode the cloud, of
// the whole call, of the server's own time within it, and of the difference, and the mean CPU time of the client; and streams,
// in turns with `segctl bench`, the C++ client. Server and clients share the machine's cores.
import {execFileSync, spawn} from 'node:child_process';
import fs from 'node:fs';
import {createRequire} from 'node:module';
import os from 'node:os';
import path from 'node:path';
import {fileURLToPath, pathToFileURL} from 'node:url';
import {parseArgs} from 'node:util';

const ROOT = path.resolve(path.dirname(fileURLToPath(import.meta.url)), '../..');
const {values, positionals} = parseArgs({
  allowPositionals: true,
  options: {build: {type: 'string', default: path.join(ROOT, 'build/release')}, seconds: {type: 'string', default: '5'},
            rounds: {type: 'string', default: '3'}},
});
const build = path.resolve(values.build), seconds = Number(values.seconds), rounds = Number(values.rounds);
const segctl = path.join(build, 'client/segctl');
const packageFolder = path.join(build, 'client/js/package');
const {Client, CODECS, encode, hasZstd, useZstd} = await import(pathToFileURL(path.join(packageFolder, 'dist/index.js')));

const median = (numbers) => [...numbers].sort((a, b) => a - b)[numbers.length >> 1];
const mean = (numbers) => numbers.reduce((sum, number) => sum + number, 0) / numbers.length;
const row = (...cells) => console.log(`| ${cells.map((cell) => (typeof cell === 'number' ? cell.toFixed(1) : cell)).join(' | ')} |`);

/** A binary PCD file of segctl, with the fields x, y, z, rgb and label. */
function readScene(file) {
  const content = fs.readFileSync(file);
  const begin = content.indexOf('DATA binary\n') + 'DATA binary\n'.length;
  const head = Object.fromEntries(content.subarray(0, begin).toString('latin1').split('\n').map((line) => {
    const [name, ...rest] = line.split(' ');
    return [name, rest];
  }));
  const [width, height, step] = [Number(head.WIDTH), Number(head.HEIGHT), head.SIZE.reduce((sum, size) => sum + Number(size), 0)];
  const offset = (name) => head.SIZE.slice(0, head.FIELDS.indexOf(name)).reduce((sum, size) => sum + Number(size), 0);
  const xyz = new Float32Array(3 * width * height), rgb = new Uint8Array(3 * width * height);
  for (let i = 0; i < width * height; ++i) {
    ['x', 'y', 'z'].forEach((axis, k) => { xyz[3 * i + k] = content.readFloatLE(begin + i * step + offset(axis)); });
    for (let k = 0; k < 3; ++k) rgb[3 * i + k] = content[begin + i * step + offset('rgb') + 2 - k];
  }
  return {xyz, rgb, width, height};
}

async function startServer(folder) {
  const portFile = path.join(folder, 'port');
  const server = spawn(path.join(build, 'server/segserve'), ['--listen', '127.0.0.1:0', '--port-file', portFile, '--log-level', 'error'],
                       {stdio: 'inherit'});
  while (!fs.existsSync(portFile) || fs.readFileSync(portFile, 'utf8').trim() === '') {
    await new Promise((resolve) => { setTimeout(resolve, 20); });
  }
  return {server, address: `127.0.0.1:${fs.readFileSync(portFile, 'utf8').trim()}`};
}

async function measureCalls(client, cloud) {
  const encoding = [], whole = [], own = [], cpu = [];
  for (const end = performance.now() + 1000 * seconds; performance.now() < end;) {
    const before = performance.now();
    encode(cloud);
    encoding.push(performance.now() - before);
    const began = performance.now(), cpuBegan = process.cpuUsage();
    const {timingsMs} = await client.segment(cloud);
    whole.push(performance.now() - began);
    const {user, system} = process.cpuUsage(cpuBegan);
    cpu.push((user + system) / 1000);
    own.push(timingsMs.total);
  }
  return [median(encoding), median(whole), median(own), median(whole.map((time, i) => time - own[i])), mean(cpu)];
}

async function framesPerSecond(client, cloud, maxInFlight) {
  const began = performance.now();
  const frames = function* () {
    while (performance.now() < began + 1000 * seconds) yield cloud;
  };
  let count = 0;
  for await (const outcome of client.stream({maxInFlight, outputs: ['labels']}).map(frames())) count += outcome.get().points > 0;
  return 1000 * count / (performance.now() - began);
}

function segctlBench(address, scene, inFlight) {
  const flags = ['--server', address, '--input', scene, '--in-flight', inFlight, '--duration', seconds, '--json', '-'];
  return JSON.parse(execFileSync(segctl, ['bench', ...flags.map(String)], {stdio: ['ignore', 'pipe', 'ignore']})).frames_per_s;
}

const folder = fs.mkdtempSync(path.join(os.tmpdir(), 'segserve-bench-'));
const scene = positionals[0] ?? path.join(folder, 'scene.pcd');
if (positionals.length === 0) execFileSync(segctl, ['synth', '-q', '-o', scene]);
const readable = path.join(folder, 'readable.pcd');
execFileSync(segctl, ['segment', scene, '--local', '-q', '-o', readable]);
const cloud = {...readScene(readable), view: 'camera'};
if (!hasZstd()) {
  const zstd = createRequire(path.join(packageFolder, 'package.json'))('@bokuweb/zstd-wasm');
  await zstd.init();
  useZstd({compress: (data) => zstd.compress(data, 1), decompress: (frame) => zstd.decompress(frame)});
}
const {server, address} = await startServer(folder);
const client = new Client(address);
console.log(`${path.basename(scene)}: ${cloud.width} x ${cloud.height} points, Node ${process.version}\n`);
row('codec', 'encode', 'call', `server's own`, 'beyond the server', 'CPU of the client');
row(...Array(6).fill('---'));
for (const codec of CODECS) row(codec, ...await measureCalls(client, {...cloud, codec}));
console.log();
row('frames in flight', 'JavaScript', 'C++ (segctl bench)');
row(...Array(3).fill('---'));
for (const inFlight of [1, 2, 4]) {
  const rates = [];
  for (let round = 0; round < rounds; ++round) {
    rates.push([await framesPerSecond(client, cloud, inFlight), segctlBench(address, scene, inFlight)]);
  }
  row(`${inFlight}`, median(rates.map(([ours]) => ours)), median(rates.map(([, theirs]) => theirs)));
}
await client.close();
server.kill('SIGTERM');
fs.rmSync(folder, {recursive: true});
