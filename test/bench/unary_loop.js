// SPDX-License-Identifier: Apache-2.0
// Calls SegmentationService.Segment over and over by grpc-js, which shares no code with segserve.
//
//   node unary_loop.js PROTO ADDRESS PLANES SECONDS CONCURRENCY [REQUEST]
//
// PROTO is the folder proto/, and PLANES a folder with x.f32, y.f32, z.f32, rgb.u8 and `shape`. So many calls are under way at
// the same time. It prints one JSON object: calls, failed, seconds, microseconds of each call, CPU seconds, bytes of an answer.
// REQUEST gets the bytes of the request in gRPC's framing, for other tools. NODE_PATH must lead to @grpc/grpc-js and
// @grpc/proto-loader.
'use strict';
const fs = require('fs');
const path = require('path');
const grpc = require('@grpc/grpc-js');
const loader = require('@grpc/proto-loader');

const [proto, address, planes, seconds, concurrency, requestFile] = process.argv.slice(2);
const FILES = {x: 'x.f32', y: 'y.f32', z: 'z.f32', rgb: 'rgb.u8'};

const definition = loader.loadSync('segserve/v1/segmentation_service.proto',
                                   {includeDirs: [proto], keepCase: true, longs: Number, enums: String, oneofs: true});
const service = grpc.loadPackageDefinition(definition).segserve.v1.SegmentationService;
const {requestSerialize: serialize} = service.service.Segment;

const [width, height] = fs.readFileSync(path.join(planes, 'shape'), 'utf8').split(' ').map(Number);
const blocks = Object.entries(FILES).map(([plane, file]) => [
  plane, {compression: 'COMPRESSION_NONE', data: fs.readFileSync(path.join(planes, file))}]);
const request = {cloud: {width, height, view: {kind: 'VIEW_KIND_CAMERA'}, planar: Object.fromEntries(blocks)}};

if (requestFile) {
  const bytes = serialize(request);
  const prefix = Buffer.alloc(5);  // not compressed, and the length
  prefix.writeUInt32BE(bytes.length, 1);
  fs.writeFileSync(requestFile, Buffer.concat([prefix, bytes]));
}

const client = new service(address, grpc.credentials.createInsecure());
const call = () => new Promise((done) => {
  client.Segment(request, {deadline: Date.now() + 30_000}, (error, answer) => done({error, answer}));
});

async function main() {
  const first = await call();
  if (first.error) throw first.error;
  if (first.answer.result.labels.count !== width * height) throw new Error('the answer has not a label for each point');
  const answerBytes = service.service.Segment.responseSerialize(first.answer).length + 5;
  const microseconds = [];
  let failed = 0;
  const cpu = process.cpuUsage(), start = performance.now(), end = start + 1000 * seconds;
  await Promise.all(Array.from({length: Number(concurrency)}, async () => {
    while (performance.now() < end) {
      const begin = performance.now();
      const {error} = await call();
      if (error) ++failed;
      else microseconds.push(1000 * (performance.now() - begin));
    }
  }));
  const {user, system} = process.cpuUsage(cpu);
  console.log(JSON.stringify({calls: microseconds.length, failed, seconds: (performance.now() - start) / 1000, microseconds,
                              cpu_seconds: (user + system) / 1e6, answer_bytes: answerBytes}));
  client.close();
}

main().catch((error) => {
  console.error(error);
  process.exit(1);
});
