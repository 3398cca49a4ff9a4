// SPDX-License-Identifier: Apache-2.0
// Single calls against a server whose answers the test chooses.
import assert from 'node:assert/strict';
import fs from 'node:fs';
import os from 'node:os';
import path from 'node:path';
import {afterEach, beforeEach, describe, it} from 'node:test';
import {FakeServer} from './fake_server.js';
import {ours, theirs} from './package.js';

const {toBinary} = await theirs('@bufbuild/protobuf');
const {Client, SegserveError} = await ours('index');
const {checkedRetry} = await ours('address_book');
const {Repetition} = await ours('repetition');
const {fitsMessage, MOST_REQUEST_BYTES, requestMessage, segmentCall} = await ours('requests');
const {TlsError} = await ours('errors');
const {SegmentRequestSchema} = await ours('gen/segserve/v1/segmentation_service_pb');
const CLOUD = {xyz: new Float32Array(60).fill(1), width: 5, height: 4, view: 'camera', outputs: ['labels']};

let server, client, folder;
beforeEach(async () => {
  server = await FakeServer.start();
  client = new Client(server.address);
  folder = fs.mkdtempSync(path.join(os.tmpdir(), 'segserve-js-'));
});
afterEach(async () => {
  await client.close();
  server.close();
  fs.rmSync(folder, {recursive: true});
});

const refusal = (code, reason = '', retryDelayMs = undefined) => new SegserveError(code, 'no', {reason, retryDelayMs});

describe('a call', () => {
  it('carries what was said of the cloud, and brings it back', async () => {
    const stamp = new Date(1_700_000_000_000);
    const result = await client.segment({...CLOUD, requestId: 'r', frameId: 'f', stamp, method: 'lambda', regions: 3,
                                         options: {voxelResolution: 0.01}, traceparent: `00-${'a'.repeat(32)}-${'b'.repeat(16)}-01`});
    assert.deepEqual(result.labels, new Uint32Array(20).fill(1));
    assert.deepEqual([result.requestId, result.frameId, result.stamp], ['r', 'f', stamp]);
    const [{requestId, options, cloud}] = server.requests;
    assert.deepEqual([requestId, options.cut, options.voxelResolution, cloud.width, cloud.height],
                     ['r', {case: 'regions', value: 3}, 0.01, 5, 4]);
    assert.match(server.metadata[0].traceparent, /^00-a+-b+-01$/);
    await assert.rejects(client.segment({...CLOUD, prompts: {include: [[3, 1]], exclude: [[0.5, 0, 1]], larger: -1}}),
                         {code: 'UNIMPLEMENTED'});  // as the server selects nothing
    const {prompts} = server.requests[1];
    assert.deepEqual([prompts.include[0].place.value.column, prompts.exclude[0].place.value.x, prompts.larger], [3, 0.5, -1]);
  });

  it('fits into a message with everything that may be said of a cloud', () => {
    let size = MOST_REQUEST_BYTES;
    while (!fitsMessage({payload: {size}})) size -= 12;
    const places = Array.from({length: 64}, () => [0.1, 0.2, 0.3]);
    const name = 'x'.repeat(256);
    const call = segmentCall({xyz: new Float32Array(3 * Math.floor(size / 12)).fill(1), view: 'world:1,2,3', codec: 'planar', requestId: name,
                              frameId: name, stamp: new Date(), prompts: {include: places, exclude: places, larger: -1}});
    assert.ok(fitsMessage(call));
    assert.ok(toBinary(SegmentRequestSchema, requestMessage(call)).length <= MOST_REQUEST_BYTES);
  });

  it('asks for health and for what the server can do', async () => {
    assert.equal(await client.health(), true);
    assert.equal((await client.info()).version, 'fake');
  });

  it('is repeated after the time that a full server asks for', async () => {
    server.errors = [refusal('RESOURCE_EXHAUSTED', 'QUEUE_FULL', 300)];
    const began = performance.now();
    await client.health();
    assert.ok(performance.now() - began >= 290);
    assert.equal(server.metadata.length, 2);
  });

  it('goes to the next server if one drains', async () => {
    const other = await FakeServer.start();
    server.errors = [refusal('UNAVAILABLE', 'DRAINING', 60_000)];
    const both = new Client(`${server.address},${other.address}`);
    assert.equal(await both.health(), true);
    assert.equal(other.metadata.length, 1);
    await both.close();
    other.close();
  });

  it('is repeated so often, and no more', async () => {
    server.errors = Array.from({length: 9}, () => refusal('UNAVAILABLE', 'DRAINING', 1));
    const few = new Client(server.address, {retry: {maxAttempts: 3, firstBackoffMs: 1}});
    await assert.rejects(few.health(), {code: 'UNAVAILABLE', reason: 'DRAINING', retryDelayMs: 1});
    assert.equal(server.metadata.length, 3);
    await few.close();
  });

  it('is not repeated in vain', async () => {
    for (const error of [refusal('INVALID_ARGUMENT', 'INVALID_FIELD'), refusal('RESOURCE_EXHAUSTED', 'LIMIT_EXCEEDED'),
                         refusal('UNAUTHENTICATED', 'TOKEN_INVALID')]) {
      server.metadata = [];
      server.errors = [error];
      await assert.rejects(client.segment(CLOUD), {name: 'SegserveError', code: error.code, reason: error.reason});
      assert.equal(server.metadata.length, 1);
    }
  });

  it('can be cancelled', async () => {
    server.errors = [refusal('RESOURCE_EXHAUSTED', 'QUEUE_FULL', 20_000)];
    const stop = new AbortController();
    setTimeout(() => stop.abort(), 100);
    await assert.rejects(client.health('', {signal: stop.signal}), {code: 'CANCELLED'});
    await assert.rejects(client.segment({...CLOUD, signal: AbortSignal.abort()}), {code: 'CANCELLED'});
    const large = {xyz: new Float32Array(3_000_000).fill(1), view: 'camera', outputs: ['labels']};
    await assert.rejects(client.segment({...large, signal: AbortSignal.abort()}), {code: 'CANCELLED'});
  });

  it('with a cloud too large for a message goes by a stream', async () => {
    const result = await client.segment({xyz: new Float32Array(3_000_000).fill(1), view: 'camera', outputs: ['labels'],
                                         requestId: 'large'});
    assert.deepEqual([result.labels.length, result.requestId], [1_000_000, 'large']);
    assert.equal(server.headers[0].encodedBytes, 12_000_000n);
    assert.equal(server.requests.length, 0);
  });

  it('is not made if it makes no sense', async () => {
    for (const wrong of [{...CLOUD, xyz: undefined}, {...CLOUD, method: 'bordr'}, {...CLOUD, threshold: 0.1, regions: 2},
                         {...CLOUD, timeoutMs: 0}, {...CLOUD, outputs: ['label']}, {...CLOUD, traceparent: 'x'},
                         {...CLOUD, options: {voxelSize: 1}}, {...CLOUD, treshold: 0.5}, {...CLOUD, frameId: 'x'.repeat(257)},
                         {...CLOUD, prompts: {include: []}}, {...CLOUD, prompts: {include: [[1]]}}, {...CLOUD, regions: 1.5}, {...CLOUD, threshold: '0.5'}, {...CLOUD, pcd: new Uint8Array(1)}]) {
      await assert.rejects(client.segment(wrong), (error) => error instanceof RangeError || error instanceof TypeError);
    }
    assert.equal(server.metadata.length, 0);
  });

  it('refuses a broken answer', async () => {
    for (const [break_, why] of [
      [(result) => { result.labels.count = 19n; }, /labels: has 19 values, but must have 20/],
      [(result) => { result.labels.data.data[3] = 2; }, /labels: holds 2, but the largest allowed value is 1/],
      [(result) => { result.labels = undefined; }, /it lacks labels/],
      [(result) => { result.summary.points = 21n; }, /the result has 21 points, but the cloud has 20/],
    ]) {
      server.result = (request) => {
        const result = FakeServer.prototype.result(request);
        break_(result);
        return result;
      };
      await assert.rejects(client.segment(CLOUD), {code: 'INTERNAL', message: why});
    }
  });

  it('refuses bytes that are no message', async () => {
    server.errors = [Buffer.from('\xff\xff\xff nonsense', 'latin1'), Buffer.from('0a05', 'hex')];
    await assert.rejects(client.segment(CLOUD), {name: 'SegserveError', code: 'INTERNAL'});
    await assert.rejects(client.info(), {name: 'SegserveError', code: 'INTERNAL'});
  });

  it('brings a token, and reads a token file again', async () => {
    const file = path.join(folder, 'token');
    fs.writeFileSync(file, 'first\n');
    const ours = new Client(server.address, {tokenFile: file});
    await ours.health();
    fs.writeFileSync(file, 'the second\n');
    await ours.health();  // it is no token: the one before it is good
    fs.writeFileSync(file, 'third-token\n');
    await ours.health();
    fs.rmSync(file);
    await ours.health();
    assert.deepEqual(server.metadata.map(({authorization}) => authorization),
                     ['Bearer first', 'Bearer first', 'Bearer third-token', 'Bearer third-token']);
    await ours.close();
  });
});

describe('settings', () => {
  it('that make no sense are refused', () => {
    for (const [address, options, why] of [
      ['', {}, /it is empty/], ['a,,b', {}, /an empty one/], ['http://a:1', {}, /is a URL/], ['a:0', {}, /the port of 'a:0'/],
      ['a', {timeoutMs: -1}, /timeoutMs/], ['a', {retry: {maxAttempts: 0}}, /retry\.maxAttempts/],
      ['a', {token: 'two words'}, /visible ASCII/], ['a', {token: 'x'}, /cross the network to a:50051/],
      ['a', {token: 'x', tokenFile: 'y', tls: true}, /one of them/], ['a', {tls: {cert: 'x'}}, /cert and key go together/],
      ['a', {tls: {ca: '/nowhere'}}, /ENOENT/], ['a', {tokenfile: 'x'}, /there is no 'tokenfile'/],
    ]) {
      assert.throws(() => new Client(address, options), why);
    }
    new Client('localhost', {token: 'x'});
    new Client('::1', {token: 'x'});
    new Client('a', {token: 'x', unprotectedToken: true});
  });
});

describe('a repetition', () => {
  const rules = {addresses: 3, first: 0, retry: checkedRetry(), waitForServer: false};

  it('tries every address once if no server answers', () => {
    const repetition = new Repetition(rules, 1000);
    const tried = [];
    assert.throws(() => {
      for (;;) {
        const attempt = repetition.next(0);
        tried.push(attempt.address);
        repetition.failed(attempt, refusal('UNAVAILABLE'), 0);
      }
    }, {code: 'UNAVAILABLE'});
    assert.deepEqual(tried, [0, 1, 2]);
  });

  it('goes on until the deadline if that was asked for, but not for TLS', () => {
    const tries = (error) => {
      const repetition = new Repetition({...rules, waitForServer: true}, 60_000);
      let count = 0;
      assert.throws(() => {
        for (let now = 0;;) {
          const attempt = repetition.next(now);
          now = attempt.notBefore;
          ++count;
          repetition.failed(attempt, error, now);
        }
      }, {code: 'UNAVAILABLE'});
      return count;
    };
    assert.ok(tries(refusal('UNAVAILABLE')) > 10);
    assert.equal(tries(new TlsError('not believed')), 3);
  });
});
