// SPDX-License-Identifier: Apache-2.0
// One connection: which messages the client sends, and which messages of a server break the protocol.
import assert from 'node:assert/strict';
import {beforeEach, describe, it} from 'node:test';
import {ours, theirs} from './package.js';
import {announced, chunk, DRAINING, opened, outcome, payloadOf, response} from './stream_harness.js';

const {create, fromBinary, toBinary} = await theirs('@bufbuild/protobuf');
const {concatenated} = await ours('bytes');
const {crc32} = await ours('crc32');
const {chunkMessage} = await ours('stream/chunks');
const {StreamProtocol} = await ours('stream/protocol');
const {FrameHeaderSchema, OutcomeKind, SegmentStreamRequestSchema, StreamOpenSchema} = await ours('gen/segserve/v1/stream_pb');

const payload = payloadOf();  // x, y, z and colors: 400 + 400 + 400 + 300 bytes
const bytes = (size) => new Uint8Array(size).fill(76);
const result = (number, size) => announced(number, size, crc32(bytes(Math.min(size, 1000))));
let protocol;

function begin(sequence) {
  protocol.begin(sequence, create(FrameHeaderSchema), payload);
}

function sent() {
  const messages = [];
  for (let next; (next = protocol.next()) !== undefined;) messages.push(fromBinary(SegmentStreamRequestSchema, next.data).kind);
  return messages;
}

function assertRefused(message, why) {
  assert.throws(() => protocol.receive(message), {code: 'INTERNAL', message: why});
}

function connected(size = 10_000) {
  const connection = new StreamProtocol(create(StreamOpenSchema));
  assert.equal(connection.next().kind, 'open');
  connection.receive(opened(2, size, 150));
  return connection;
}

beforeEach(() => { protocol = connected(); });

describe('the protocol', () => {
  it('cuts a payload into chunks that fit its checksum', () => {
    begin(7);
    const [header, ...chunks] = sent();
    assert.equal(header.value.sequence, 1n, 'the number on the wire, not the sequence');
    assert.ok(chunks.length > 9);
    assert.ok(chunks.every(({value}) => value.data.length > 0 && value.data.length <= 150 && value.sequence === 1n));
    const data = concatenated(chunks.map(({value}) => value.data));
    assert.deepEqual(data, concatenated(payload.blocks));
    assert.deepEqual([BigInt(data.length), crc32(data)], [header.value.encodedBytes, header.value.crc32]);
  });

  it('writes chunks as protobuf does', () => {
    for (const [number, size] of [[1, 1], [200, 150], [2 ** 40 + 3, 300_000]]) {
      const kind = {case: 'chunk', value: {sequence: BigInt(number), data: bytes(size)}};
      const expected = toBinary(SegmentStreamRequestSchema, create(SegmentStreamRequestSchema, {kind}));
      assert.deepEqual(chunkMessage(number, bytes(size)), expected);
    }
  });

  it('sends one payload after the other, within the credit', () => {
    assert.ok(protocol.hasTurn());
    begin(1);
    assert.ok(!protocol.hasTurn());
    sent();
    assert.ok(protocol.hasTurn());
    begin(2);
    sent();
    assert.ok(!protocol.hasTurn(), 'the credit is for two frames');
  });

  it('gets credit back after the last byte of the answer', () => {
    assert.equal(protocol.fit(10_001), 'NEVER');
    begin(1);
    assert.equal(protocol.fit(9000), 'LATER');
    sent();
    assert.equal(protocol.receive(result(1, 20)).kind, 'BEGUN');
    assert.equal(protocol.fit(9000), 'LATER');
    const event = protocol.receive(chunk(1, bytes(20)));
    assert.deepEqual([event.kind, event.isIntact], ['OUTCOME', true]);
    assert.deepEqual(event.outcome.result.labels.data.data, bytes(20));
    assert.equal(protocol.fit(9000), 'NOW');
  });

  it('notices a damaged answer', () => {
    begin(1);
    sent();
    protocol.receive(announced(1, 20, crc32(bytes(20)) ^ 1));
    assert.equal(protocol.receive(chunk(1, bytes(20))).isIntact, false);
  });

  it('sends no chunks after a cancel or an outcome', () => {
    begin(1);
    protocol.next();
    protocol.next();
    protocol.cancel(1);
    assert.deepEqual(sent().map((message) => message.case), ['cancel']);
    begin(2);
    protocol.next();
    protocol.next();
    protocol.receive(outcome(2, OutcomeKind.FAILED));
    assert.deepEqual(sent(), []);
  });

  it('ends when the upload is through', () => {
    begin(1);
    protocol.end();
    assert.ok(!protocol.hasTurn());
    assert.ok(!protocol.wantsHalfClose());
    sent();
    assert.ok(protocol.wantsHalfClose());
  });

  it('refuses what no server may say', () => {
    begin(1);
    sent();
    assertRefused(outcome(2), /it ended frame 2, which it does not have/);
    assertRefused(chunk(1, bytes(1)), /belongs to no result/);
    assertRefused(opened(), /opened the stream twice/);
    assertRefused(outcome(1, OutcomeKind.RESULT, {encodedBytes: 21n, result: {labels: {data: {encodedBytes: 20n}}}}),
                  /a result of 21 bytes whose blocks have 20/);
    assertRefused(outcome(1, OutcomeKind.RESULT, {encodedBytes: 2n ** 64n - 1n}), /are allowed/);
    const most = 100 * 29 + (64 << 10);  // for 100 points
    assertRefused(result(1, most + 1), /67\d\d\d are allowed|are allowed/);
    protocol.receive(result(1, 20));
    assertRefused(chunk(1, bytes(21)), /a chunk of 21 bytes where 20 were missing/);
    assertRefused(chunk(1, bytes(0)), /a chunk of 0 bytes/);
    assertRefused(chunk(2, bytes(5)), /belongs to no result/);
    assertRefused(result(1, 20), /another message interrupted/);
  });

  it('accepts the largest result that a cloud can have', () => {
    begin(1);
    sent();
    assert.equal(protocol.receive(result(1, 100 * 29 + (64 << 10))).kind, 'BEGUN');
  });

  it('joins chunks of any size', () => {
    begin(1);
    sent();
    const data = Uint8Array.from({length: 3000}, (_, i) => i * i);
    protocol.receive(announced(1, data.length, crc32(data)));
    const sizes = [1, 1, 700, 3, 1000, 1295];
    const events = sizes.map((size, i) => {
      const from = sizes.slice(0, i).reduce((sum, each) => sum + each, 0);
      return protocol.receive(chunk(1, data.subarray(from, from + size)));
    });
    assert.deepEqual(events.map(({kind}) => kind), [...Array(5).fill('NOTHING'), 'OUTCOME']);
    assert.ok(events[5].isIntact);
    assert.deepEqual(events[5].outcome.result.labels.data.data, data);
  });

  it('refuses everything before the server has opened the stream', () => {
    protocol = new StreamProtocol(create(StreamOpenSchema));
    assertRefused(DRAINING, /its first message was not StreamOpened/);
    assertRefused(response('opened', {}), /it granted no credit/);
  });
});
