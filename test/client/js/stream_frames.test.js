// SPDX-License-Identifier: Apache-2.0
// The decisions of a stream about its frames. The test is the clock, the transport and the servers.
import assert from 'node:assert/strict';
import {describe, it} from 'node:test';
import {ours} from './package.js';
import {announced, chunk, StreamHarness} from './stream_harness.js';

const {SegserveError} = await ours('errors');
const {crc32} = await ours('crc32');
const {OutcomeKind} = await ours('gen/segserve/v1/stream_pb');
const {ServiceTime} = await ours('stream/service_time');

const ofText = (text) => new TextEncoder().encode(text);

describe('frames', () => {
  it('are not sent before the server agrees', () => {
    const stream = new StreamHarness();
    stream.act();
    assert.equal(stream.connections.length, 1);
    stream.send();
    assert.deepEqual(stream.sent().map((message) => message.case), ['open']);
    stream.open();
    const [header, ...chunks] = stream.sent();
    assert.equal(header.value.encodedBytes, 1500n);
    const {x} = header.value.cloud.payload.value;
    assert.deepEqual([x.data.length, x.encodedBytes], [0, 400n]);
    assert.deepEqual(chunks.map((message) => message.value.data.length), [400, 400, 400, 300]);
  });

  it('keep to the window', () => {
    const stream = new StreamHarness({maxInFlight: 2, maxWaiting: 10});
    stream.open(4);
    for (let i = 0; i < 5; ++i) stream.send();
    assert.equal(stream.begun(), 2);
    stream.end(1);
    assert.equal(stream.begun(), 0, 'the result was not taken yet');
    assert.equal(stream.taken().length, 1);
    assert.equal(stream.begun(), 1);
  });

  it('keep to the credit of the server in frames and bytes', () => {
    const stream = new StreamHarness({maxInFlight: 10, maxWaiting: 10});
    stream.open(3);
    for (let i = 0; i < 5; ++i) stream.send();
    assert.equal(stream.begun(), 3);
    stream.end(1);
    assert.equal(stream.begun(), 1);
    const small = new StreamHarness({maxInFlight: 10, maxWaiting: 10});
    small.open(10, 3200);  // enough for two frames of 1500 bytes
    for (let i = 0; i < 5; ++i) small.send();
    assert.equal(small.begun(), 2);
    small.end(2);
    assert.equal(small.begun(), 1);
  });

  it('beyond the credit fail and say why', () => {
    const stream = new StreamHarness();
    stream.open(4, 1499);
    stream.send();
    assert.equal(stream.begun(), 0);
    assert.deepEqual(stream.taken(), ['1 FAILED']);
    const {code, reason, metadata} = stream.last.error;
    assert.deepEqual([code, reason], ['INVALID_ARGUMENT', 'LIMIT_EXCEEDED']);
    assert.deepEqual(metadata, {limit: 'credit.bytes', allowed: '1499', actual: '1500'});
  });

  it('wait, are refused, or drop the oldest, as was asked for', () => {
    const block = new StreamHarness({whenBehind: 'block', maxWaiting: 2});
    block.send();
    assert.equal(block.scheduler.admission(), 'OPEN');
    block.send();
    assert.equal(block.scheduler.admission(), 'WAIT');
    const reject = new StreamHarness({whenBehind: 'reject'});
    reject.send();
    assert.equal(reject.scheduler.admission(), 'REFUSED');
    assert.equal(reject.scheduler.refusal().code, 'RESOURCE_EXHAUSTED');
    reject.scheduler.finishSending();
    assert.equal(reject.scheduler.refusal().code, 'FAILED_PRECONDITION');
    const drop = new StreamHarness({whenBehind: 'drop_oldest', maxWaiting: 2});
    for (let i = 0; i < 4; ++i) {
      assert.equal(drop.scheduler.admission(), 'OPEN');
      drop.send();
    }
    assert.deepEqual(drop.taken(), ['1 DROPPED', '2 DROPPED']);
  });

  it('on their way are not dropped', () => {
    const stream = new StreamHarness({whenBehind: 'drop_oldest', maxInFlight: 1});
    stream.open();
    stream.send();
    assert.equal(stream.begun(), 1);
    stream.send();
    stream.send();
    stream.end(1);
    assert.deepEqual(stream.taken(), ['1 RESULT', '2 DROPPED']);
  });

  it('come back in the order asked for', () => {
    for (const [order, early, late] of [['sent', [], ['1 RESULT', '2 RESULT', '3 RESULT']],
                                        ['done', ['3 RESULT', '2 RESULT'], ['1 RESULT']]]) {
      const stream = new StreamHarness({order, maxWaiting: 4});
      stream.open();
      for (let i = 0; i < 3; ++i) stream.send();
      assert.equal(stream.begun(), 3);
      stream.end(3);
      stream.end(2);
      assert.deepEqual(stream.taken(), early);
      stream.end(1);
      assert.deepEqual(stream.taken(), late);
    }
  });

  it('that came early do not shut out the one they wait for', () => {
    const stream = new StreamHarness({maxInFlight: 2, maxWaiting: 4});
    stream.open();
    for (let i = 0; i < 3; ++i) stream.send();
    assert.equal(stream.begun(), 2);
    stream.fail(1, new SegserveError('ABORTED', 'crc'));
    assert.equal(stream.begun(), 1);  // frame 3 has number 3 on the wire, while frame 1 waits
    stream.end(2);
    stream.end(3);
    stream.passTime(1000);
    assert.equal(stream.begun(), 1);  // frame 1 has number 4
    stream.end(4);
    assert.equal(stream.taken().length, 3);
  });

  it('report the bytes of all messages of an outcome', () => {
    const stream = new StreamHarness();
    stream.open();
    const data = new Uint8Array(1200).fill(7);
    for (const part of [400, 1200]) {
      const number = stream.send();
      stream.sent();
      let size = stream.answer(announced(number, 1200, crc32(data)));
      for (let begin = 0; begin < 1200; begin += part) size += stream.answer(chunk(number, data.subarray(0, part)));
      assert.equal(stream.taken().length, 1);
      assert.equal(stream.last.report.bytesReceived, size);
    }
  });

  it('with a damaged result are sent again', () => {
    const stream = new StreamHarness();
    stream.open();
    stream.send();
    assert.equal(stream.begun(), 1);
    stream.answer(announced(1, 4, crc32(ofText('good'))));
    stream.answer(chunk(1, ofText('evil')));
    assert.deepEqual(stream.taken(), []);
    assert.equal(stream.begun(), 1);
    assert.equal(stream.connections.length, 1);
  });

  it('of higher priority go first', () => {
    const stream = new StreamHarness({order: 'done', maxInFlight: 1, maxWaiting: 4});
    for (const priority of [0, 5, 5]) stream.send({priority});
    stream.open();
    assert.equal(stream.begun(), 1);
    stream.end(1);
    assert.deepEqual(stream.taken(), ['2 RESULT']);
  });

  it('have an age that counts from the capture', () => {
    const stream = new StreamHarness({maxWaiting: 3});
    stream.send({captured: stream.now - 250, timeToLiveMs: 1000});
    stream.send({captured: stream.now - 900, timeToLiveMs: 1000});
    stream.passTime(250);
    stream.open();
    const headers = stream.sent().filter((message) => message.case === 'frame');
    assert.equal(headers.length, 1);
    assert.equal(headers[0].value.age.nanos, 500_000_000);
    assert.equal(headers[0].value.timeToLive.seconds, 1n);
    stream.end(1, OutcomeKind.EXPIRED);
    assert.deepEqual(stream.taken(), ['1 EXPIRED', '2 EXPIRED']);
  });

  it('say when the tick is needed next', () => {
    const stream = new StreamHarness({maxWaiting: 3});
    stream.open();
    stream.send({timeoutMs: 700});
    stream.send({timeToLiveMs: 300});
    assert.equal(stream.act().wakeAt, stream.now + 300);
  });

  it('that are cancelled end once', () => {
    const stream = new StreamHarness({maxInFlight: 1, maxWaiting: 3});
    stream.open();
    stream.send();
    stream.send();
    assert.equal(stream.begun(), 1);
    for (const sequence of [2, 1, 77]) stream.scheduler.cancel(sequence, stream.now);
    assert.deepEqual(stream.sent().map((message) => [message.case, message.value.sequence]), [['cancel', 1n]]);
    stream.end(1, OutcomeKind.CANCELLED);
    assert.deepEqual(stream.taken(), ['1 CANCELLED', '2 CANCELLED']);
    stream.scheduler.cancel(1, stream.now);
    assert.deepEqual(stream.taken(), []);
  });

  it('that are cancelled are not sent again', () => {
    const stream = new StreamHarness();
    stream.open();
    stream.send();
    assert.equal(stream.begun(), 1);
    stream.scheduler.cancel(1, stream.now);
    stream.close(new SegserveError('UNAVAILABLE', 'gone'));
    assert.deepEqual(stream.taken(), ['1 CANCELLED']);
  });

  it('tell their deadline as a time to live', () => {
    const stream = new StreamHarness({maxWaiting: 10});
    stream.open();
    stream.send({timeoutMs: 750});
    stream.send({timeToLiveMs: 250, timeoutMs: 750});
    stream.send({timeToLiveMs: 875, timeoutMs: 750});
    const headers = stream.sent().filter((message) => message.case === 'frame');
    assert.deepEqual(headers.map(({value}) => value.timeToLive.nanos / 1e6), [750, 250, 750]);
    for (const number of [1, 2, 3]) stream.end(number, OutcomeKind.EXPIRED);
    assert.deepEqual(stream.taken(), ['1 FAILED', '2 EXPIRED', '3 FAILED']);
    assert.equal(stream.last.error.code, 'DEADLINE_EXCEEDED');
  });

  it('end at their deadline, and the answer counts no more', () => {
    const stream = new StreamHarness();
    stream.open();
    stream.send({timeoutMs: 100});
    assert.equal(stream.begun(), 1);
    stream.passTime(100);
    assert.deepEqual(stream.sent().map((message) => message.case), ['cancel']);
    assert.deepEqual(stream.taken(), ['1 FAILED']);
    assert.equal(stream.last.error.code, 'DEADLINE_EXCEEDED');
    stream.end(1);
    assert.deepEqual(stream.taken(), []);
  });
});

describe('a server that took 500 ms for each frame', () => {
  const slow = () => {
    const stream = new StreamHarness({order: 'done', maxInFlight: 2, maxWaiting: 10});
    stream.open();
    for (let number = 1; number <= 30; ++number) {
      stream.send();
      stream.sent();
      stream.passTime(500);
      stream.end(number);
      stream.taken();
    }
    return stream;
  };

  it('gets no frame that would come too late if another waits', () => {
    const stream = slow();
    const first = stream.send({timeoutMs: 1000});
    stream.send({timeoutMs: 1000});
    const late = stream.send({timeoutMs: 1000});
    assert.equal(stream.begun(), 2);
    stream.passTime(600);
    const fresh = stream.send({timeoutMs: 1000});
    stream.end(31);
    assert.deepEqual(stream.taken(), [`${first} RESULT`]);
    assert.equal(stream.begun(), 1);
    assert.deepEqual(stream.taken(), [`${late} FAILED`]);
    stream.end(33);
    assert.deepEqual(stream.taken(), [`${fresh} RESULT`]);
  });

  it('gets a late frame if no other waits', () => {
    const stream = slow();
    stream.send({timeoutMs: 5000});
    const hurried = stream.send({timeoutMs: 100});
    assert.equal(stream.begun(), 2);
    stream.end(32);
    assert.deepEqual(stream.taken(), [`${hurried} RESULT`]);
  });
});

describe('the service time', () => {
  it('is above the mean by the spread', () => {
    assert.equal(new ServiceTime().bound(), 0);
    const steady = new ServiceTime(), changing = new ServiceTime();
    for (let i = 0; i < 100; ++i) {
      steady.add(100);
      changing.add(i % 2 ? 80 : 120);
    }
    assert.ok(Math.abs(steady.bound() - 100) < 1);
    assert.ok(changing.bound() > 150 && changing.bound() < 200);
  });

  it('does not fall by a frame that was given up', () => {
    const times = new ServiceTime();
    for (let i = 0; i < 100; ++i) times.add(100);
    const before = times.bound();
    times.addAtLeast(1);
    assert.equal(times.bound(), before);
    times.addAtLeast(500);
    assert.ok(times.bound() > before);
  });
});

describe('rules that make no sense', () => {
  it('are all named', () => {
    assert.throws(() => new StreamHarness({maxInFlight: 0, frameTimeoutMs: 0.1}),
                  /maxInFlight: 0 is not in \[1, 1024\]; frameTimeoutMs: 0\.1 is not in/);
    assert.throws(() => new StreamHarness({whenBehind: 'panic'}), /whenBehind: there is no 'panic'; there are block, /);
  });
});
