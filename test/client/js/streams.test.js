// SPDX-License-Identifier: Apache-2.0
// Streams against a server whose answers the test chooses.
import assert from 'node:assert/strict';
import {afterEach, beforeEach, describe, it} from 'node:test';
import {FakeServer, OutcomeKind, response, resultOf} from './fake_server.js';
import {ours} from './package.js';

const {Client, SegserveError} = await ours('index');
const CLOUD = {xyz: new Float32Array(60).fill(1), width: 5, height: 4};
const failed = (code, message = 'no') => new SegserveError(code, message);

let server, closing;
beforeEach(async () => {
  closing = [];
  server = await serve();
});
afterEach(async () => {
  for (const close of closing.reverse()) await close();
});

async function serve() {
  const started = await FakeServer.start();
  closing.push(() => started.close());
  return started;
}

function streamTo(servers, rules = {}) {
  const client = new Client(servers.map(({address}) => address).join(','));
  closing.push(() => client.close());
  return client.stream({view: 'camera', outputs: ['labels'], codec: 'planar', ...rules});
}

const collected = async (outcomes) => {
  const all = [];
  for await (const outcome of outcomes) all.push(outcome);
  return all;
};
const kindsOf = (outcomes) => outcomes.map(({kind}) => kind);
const sleep = (ms) => new Promise((resolve) => { setTimeout(resolve, ms); });

async function until(happened) {
  for (const end = Date.now() + 20_000; !happened();) {
    assert.ok(Date.now() < end, 'it did not happen in time');
    await sleep(5);
  }
}

/** Makes a server keep its frames. Returns a function that lets it go on. */
function hold(held) {
  let release;
  const released = new Promise((resolve) => { release = resolve; });
  closing.push(() => release());
  held.onFrame = async (header) => {
    await released;
    return resultOf(header);
  };
  return release;
}

describe('a stream', () => {
  it('echoes and reports', async () => {
    const stream = streamTo([server]);
    const before = performance.now();
    const stamp = new Date(1_700_000_000_123);
    assert.equal(await stream.send({...CLOUD, requestId: 'r', frameId: 'f', priority: 3, stamp}), 1);
    const outcome = await stream.next(20_000);
    assert.deepEqual([outcome.requestId, outcome.frameId, outcome.stamp, outcome.get().frameId], ['r', 'f', stamp, 'f']);
    assert.deepEqual(outcome.get().labels, new Uint32Array(20).fill(1));
    const {report} = outcome;
    const times = [before, report.handedOver, report.headerSent, report.payloadSent, report.outcomeBegun, report.outcomeDone];
    assert.deepEqual(times, times.toSorted?.((a, b) => a - b) ?? [...times].sort((a, b) => a - b));
    assert.deepEqual([report.attempts, report.address], [1, server.address]);
    assert.ok(report.bytesSent > 240 && report.bytesReceived > 20);
    const [header] = server.headers;
    assert.deepEqual([header.priority, header.requestId, header.stamp.seconds], [3, 'r', 1_700_000_000n]);
    assert.ok(!stream.done);
    stream.finish();
    assert.equal(await stream.next(), undefined);
    assert.ok(stream.done);
  });

  it('refuses at once what makes no sense', async () => {
    for (const wrong of [{whenBehind: 'panic'}, {order: 'random'}, {outputs: ['colors']}, {maxInFlight: 0}, {method: 'x'}]) {
      assert.throws(() => streamTo([server], wrong), RangeError);
    }
    assert.throws(() => streamTo([server], {maxInflight: 1}), /there is no 'maxInflight'/);
    const stream = streamTo([server]);
    for (const wrong of [{xyz: new Float32Array(2)}, {...CLOUD, outputs: ['x']}, {...CLOUD, timeoutMs: -1},
                         {...CLOUD, timeToLiveMs: -1}, {...CLOUD, priority: 0.5}, {...CLOUD, rgb: new Uint8Array(3)}]) {
      await assert.rejects(stream.send(wrong), RangeError);
    }
    await assert.rejects(stream.send({...CLOUD, timeToLive: 1}), /there is no 'timeToLive'/);
    assert.equal(await stream.send(CLOUD), 1);
  });

  it('takes no frame after the last', async () => {
    const stream = streamTo([server]);
    stream.finish();
    await assert.rejects(stream.send(CLOUD), {code: 'FAILED_PRECONDITION'});
    assert.deepEqual(await collected(stream), []);
  });

  it('outlives a failed frame', async () => {
    server.onFrame = (header) => (header.sequence > 1n ? resultOf(header) : [response('outcome', {
      sequence: 1n, kind: OutcomeKind.FAILED, status: {code: 3, message: 'wrong', details: []}})]);
    const outcomes = await collected(streamTo([server]).map([CLOUD, CLOUD]));
    assert.deepEqual(kindsOf(outcomes), ['FAILED', 'RESULT']);
    assert.throws(() => outcomes[0].get(), {code: 'INVALID_ARGUMENT', message: 'wrong'});
  });

  it('makes a broken result an error of its frame', async () => {
    server.onFrame = ({sequence}) => [response('outcome', {sequence, kind: OutcomeKind.RESULT})];
    const [outcome] = await collected(streamTo([server]).map([CLOUD]));
    assert.deepEqual([outcome.kind, outcome.error.code], ['FAILED', 'INTERNAL']);
    assert.match(outcome.error.message, /the answer is broken: it has no summary/);
  });

  it('that breaks is opened again, and nothing is lost', async () => {
    server.errors = [failed('UNAVAILABLE', 'not yet'), failed('UNAVAILABLE', 'not yet')];
    const outcomes = await collected(streamTo([server]).map(Array(5).fill(CLOUD)));
    assert.deepEqual(kindsOf(outcomes), Array(5).fill('RESULT'));
    assert.deepEqual(outcomes.map(({sequence}) => sequence), [1, 2, 3, 4, 5]);
    assert.equal(server.metadata.length, 3);
  });

  it('ends by a server that refuses us', async () => {
    server.errors = [failed('UNAUTHENTICATED', 'who are you?')];
    const stream = streamTo([server]);
    await stream.send(CLOUD);
    assert.equal((await stream.next()).error.code, 'UNAUTHENTICATED');
    await assert.rejects(stream.send(CLOUD), {code: 'UNAUTHENTICATED'});
    assert.equal(await stream.next(), undefined);
    assert.equal(server.metadata.length, 1);
  });

  it('leaves a silent server for the next', async () => {
    const other = await serve();
    hold(server);
    server.silent = true;
    const [outcome] = await collected(streamTo([server, other], {progressTimeoutMs: 400}).map([CLOUD]));
    assert.deepEqual([outcome.kind, outcome.report.attempts, outcome.report.address], ['RESULT', 2, other.address]);
  });

  it('does not take a server for dead that computes for long', async () => {
    const release = hold(server);
    setTimeout(release, 1500);
    const [outcome] = await collected(streamTo([server], {progressTimeoutMs: 400}).map([CLOUD]));
    assert.deepEqual([outcome.kind, outcome.report.attempts], ['RESULT', 1]);
  });

  it('keeps the deadline of a frame whatever the server does', async () => {
    hold(server);
    const stream = streamTo([server]);
    await stream.send({...CLOUD, timeoutMs: 200});
    const began = performance.now();
    assert.equal(await stream.next(50), undefined);
    assert.equal((await stream.next()).error.code, 'DEADLINE_EXCEEDED');
    assert.ok(performance.now() - began < 10_000);
  });

  it('blocks for the timeout of the frame', async () => {
    hold(server);
    const stream = streamTo([server], {maxInFlight: 1});
    await stream.send(CLOUD);
    await stream.send(CLOUD);
    await assert.rejects(stream.send({...CLOUD, timeoutMs: 300}), {code: 'DEADLINE_EXCEEDED', message: /frames wait already/});
  });

  it('rejects, or drops the oldest', async () => {
    const release = hold(server);
    const stream = streamTo([server], {maxInFlight: 1, whenBehind: 'reject'});
    await stream.send(CLOUD);
    await assert.rejects(stream.send(CLOUD), {code: 'RESOURCE_EXHAUSTED'});
    const newest = streamTo([server], {maxInFlight: 1, whenBehind: 'drop_oldest'});
    await newest.send(CLOUD);
    await until(() => server.headers.length >= 2);
    for (let i = 0; i < 3; ++i) await newest.send(CLOUD);
    newest.finish();
    release();
    assert.deepEqual(kindsOf(await collected(newest)), ['RESULT', 'DROPPED', 'DROPPED', 'RESULT']);
  });

  it('fails at once without a server if told to', async () => {
    server.close();
    const [outcome] = await collected(streamTo([server], {waitForServer: false}).map([CLOUD]));
    assert.equal(outcome.error.code, 'UNAVAILABLE');
    assert.match(outcome.error.message, /no answer from 127\.0\.0\.1:\d+: connect ECONNREFUSED .*; is segserve running there\?/);
  });

  it('cancels what is unfinished when it is closed', async () => {
    hold(server);
    const stream = streamTo([server]);
    await stream.send(CLOUD);
    await until(() => server.headers.length > 0);
    await stream.close();
    assert.deepEqual(kindsOf(await collected(stream)), ['CANCELLED']);
    await stream.close();
  });

  it('ends with its client', async () => {
    hold(server);
    const client = new Client(server.address);
    const stream = client.stream({view: 'camera'});
    await stream.send(CLOUD);
    await until(() => server.headers.length > 0);
    await client.close();
    assert.deepEqual(kindsOf(await collected(stream)), ['CANCELLED']);
    await assert.rejects(stream.send(CLOUD), {code: 'FAILED_PRECONDITION'});
    await assert.rejects(client.health(), {code: 'FAILED_PRECONDITION', message: 'the client was closed'});
  });

  it('takes frames of a generator, and hands its error on', async () => {
    const frames = async function* () {
      for (let i = 0; i < 3; ++i) {
        await sleep(5);
        yield {...CLOUD, requestId: `${i}`};
      }
      throw new Error('the camera broke');
    };
    const seen = [];
    await assert.rejects(async () => {
      for await (const {requestId} of streamTo([server]).map(frames())) seen.push(requestId);
    }, /the camera broke/);
    assert.deepEqual(seen, ['0', '1', '2']);
  });

  it('gives a frame up whose answer is never a message', async () => {
    server.onFrame = () => [Buffer.from('\xff\xff\xff nonsense', 'latin1')];
    const [outcome] = await collected(streamTo([server]).map([CLOUD]));
    assert.deepEqual([outcome.kind, outcome.error.code, outcome.report.attempts], ['FAILED', 'INTERNAL', 5]);
  });

  it('asks for no more frames when the caller wants no more outcomes', async () => {
    let asked = 0;
    const frames = function* () {
      for (;; ++asked) yield CLOUD;
    };
    const stream = streamTo([server]);
    for await (const {kind} of stream.map(frames())) {
      assert.equal(kind, 'RESULT');
      break;
    }
    await sleep(50);
    const before = asked;
    await sleep(50);
    assert.ok(asked === before && asked < 20, `${asked} frames were asked for`);
  });

  it('takes frames from several senders at the same time', async () => {
    const stream = streamTo([server], {maxWaiting: 2, order: 'done'});
    const senders = Array.from({length: 4}, async () => {
      for (let i = 0; i < 10; ++i) await stream.send(CLOUD);
    });
    const outcomes = [];
    while (outcomes.length < 40) outcomes.push(await stream.next(20_000));
    await Promise.all(senders);
    assert.deepEqual(outcomes.map(({sequence}) => sequence).sort((a, b) => a - b), Array.from({length: 40}, (_, i) => i + 1));
  });
});
