// SPDX-License-Identifier: Apache-2.0
// A client of SegmentStream that shares no code with segserve: it uses grpc-js and the .proto files alone.
//
//   node stream_client.js PROTO ADDRESS FOLDER...
//
// PROTO is the folder proto/. The folders are those of stream_client.py. NODE_PATH must lead to @grpc/grpc-js and
// @grpc/proto-loader.
'use strict';
const fs = require('fs');
const path = require('path');
const grpc = require('@grpc/grpc-js');
const loader = require('@grpc/proto-loader');

const [proto, address, ...folders] = process.argv.slice(2);
const PLANES = {x: 'x.f32', y: 'y.f32', z: 'z.f32', rgb: 'rgb.u8'};

const definition = loader.loadSync('segserve/v1/segmentation_service.proto',
                                   {includeDirs: [proto], keepCase: true, longs: Number, enums: String, oneofs: true});
const service = grpc.loadPackageDefinition(definition).segserve.v1.SegmentationService;

/** The header of a cloud and the bytes that follow it. */
function readFrame(sequence, folder) {
  const [width, height] = fs.readFileSync(path.join(folder, 'shape'), 'utf8').split(' ').map(Number);
  const planar = {};
  const planes = [];
  for (const [plane, file] of Object.entries(PLANES)) {
    const bytes = fs.readFileSync(path.join(folder, file));
    planar[plane] = {compression: 'COMPRESSION_NONE', decoded_bytes: bytes.length, encoded_bytes: bytes.length};
    planes.push(bytes);
  }
  const payload = Buffer.concat(planes);
  const cloud = {width, height, view: {kind: 'VIEW_KIND_CAMERA'}, planar};
  return {header: {sequence, encoded_bytes: payload.length, points: width * height, cloud}, payload};
}

/** Labels of 1, 2 or 4 bytes each as labels of 4. */
function widen(labels, bytes) {
  const wide = Buffer.alloc(4 * labels.count);
  for (let i = 0; i < labels.count; ++i) {
    wide.writeUInt32LE(bytes.readUIntLE(i * labels.bytes_per_value, labels.bytes_per_value), 4 * i);
  }
  return wide;
}

function fail(why) {
  console.error(why);
  process.exit(1);
}

const client = new service(address, grpc.credentials.createInsecure());
const call = client.SegmentStream({deadline: Date.now() + 100000});
const waiting = folders.map((folder, i) => ({folder, ...readFrame(i + 1, folder)}));
const sent = new Map();
let credit, chunkBytes;
let result = null;  // the outcome whose chunks come

function sendWhatTheCreditAllows() {
  while (waiting.length > 0 && credit.frames > 0 && credit.bytes >= waiting[0].payload.length) {
    const frame = waiting.shift();
    const sequence = frame.header.sequence;
    credit = {frames: credit.frames - 1, bytes: credit.bytes - frame.payload.length};
    sent.set(sequence, frame);
    call.write({frame: frame.header});
    for (let start = 0; start < frame.payload.length; start += chunkBytes) {
      call.write({chunk: {sequence, data: frame.payload.subarray(start, start + chunkBytes)}});
    }
  }
  if (waiting.length === 0 && sent.size === 0) call.end();
}

function finish(outcome, bytes) {
  const frame = sent.get(outcome.sequence);
  fs.writeFileSync(path.join(frame.folder, 'labels.u32'), widen(outcome.result.labels, bytes));
  sent.delete(outcome.sequence);
  credit = {frames: credit.frames + 1, bytes: credit.bytes + frame.payload.length};
  sendWhatTheCreditAllows();
}

call.on('data', (response) => {
  if (response.opened) {
    credit = response.opened.credit;
    chunkBytes = response.opened.max_chunk_bytes;
    sendWhatTheCreditAllows();
  } else if (response.outcome) {
    if (response.outcome.kind !== 'OUTCOME_KIND_RESULT') fail(JSON.stringify(response.outcome));
    result = {outcome: response.outcome, parts: [], missing: response.outcome.encoded_bytes};
  } else if (response.chunk) {
    result.parts.push(response.chunk.data);
    result.missing -= response.chunk.data.length;
    if (result.missing === 0) finish(result.outcome, Buffer.concat(result.parts));
  }
});
call.on('error', (error) => fail(error.message));
call.on('end', () => {
  if (sent.size + waiting.length > 0) fail('the stream ended early');
  client.close();
});

call.write({open: {client_name: 'grpc-js'}});
