// SPDX-License-Identifier: Apache-2.0
// The decisions of a stream about its connections. The test is the clock, the transport and the servers.
import assert from 'node:assert/strict';
import {describe, it} from 'node:test';
import {ours} from './package.js';
import {DRAINING, OLD, outcome, StreamHarness} from './stream_harness.js';

const {OutageError, SegserveError, TlsError} = await ours('errors');
const gone = (message = 'gone') => new SegserveError('UNAVAILABLE', message);

/** A stream that has sent one frame. */
function withOneFrame(rules) {
  const stream = new StreamHarness(rules);
  stream.open();
  stream.send();
  assert.equal(stream.begun(), 1);
  return stream;
}

describe('a broken connection', () => {
  it('moves its frames to the next address', () => {
    const stream = withOneFrame({maxWaiting: 3});
    stream.send();
    assert.equal(stream.begun(), 1);
    stream.close(new SegserveError('CANCELLED', ''));  // a server that shuts down ends calls so
    stream.open();
    assert.deepEqual(stream.actions.map(({address}) => address), [0, 1]);
    assert.equal(stream.begun(), 2);
    stream.end(2);
    stream.end(1);
    assert.equal(stream.taken().length, 2);
    assert.deepEqual([stream.last.report.attempts, stream.last.report.address], [2, 'b']);
  });

  it('is made again after a while if there is one address', () => {
    const stream = new StreamHarness({addresses: ['a']});
    stream.open();
    stream.close(gone());
    stream.act();
    assert.equal(stream.connections.length, 1);
    stream.passTime(50);
    assert.equal(stream.connections.length, 2);
  });

  it('is not made for a frame that breaks every connection', () => {
    const stream = new StreamHarness({retry: {maxAttempts: 3}});
    stream.send();
    for (let i = 0; i < 3; ++i) {
      stream.passTime(2500);
      stream.open();
      assert.equal(stream.begun(), 1);
      stream.close(gone('crashed'));
    }
    assert.deepEqual(stream.taken(), ['1 FAILED']);
    assert.equal(stream.last.error.message, 'crashed');
  });
});

describe('an outage', () => {
  it('ends the stream when it is long', () => {
    const stream = withOneFrame({addresses: ['a'], maxWaiting: 3, frameTimeoutMs: 60_000, longestOutageMs: 4000});
    stream.close(gone());
    for (let i = 0; i < 3; ++i) stream.passTime(1000);
    stream.open();  // that was short enough
    assert.equal(stream.begun(), 1);
    stream.passTime(1000);
    stream.close(gone('gone again'));
    stream.act();
    stream.passTime(3500);
    assert.deepEqual(stream.taken(), []);
    assert.equal(stream.scheduler.admission(), 'OPEN');
    stream.passTime(500);
    assert.deepEqual(stream.taken(), ['1 FAILED']);
    assert.ok(stream.last.error instanceof OutageError);
    assert.equal(stream.last.error.message, 'no server has been in reach for 4 s (gone again)');
    assert.ok(stream.scheduler.refusal() instanceof OutageError);
    assert.ok(stream.scheduler.exhausted());
  });

  it('does not begin while a server that drains computes', () => {
    const stream = withOneFrame({addresses: ['a'], frameTimeoutMs: 60_000, longestOutageMs: 4000});
    const old = stream.newest;
    stream.answer(DRAINING);
    for (let i = 0; i < 20; ++i) {
      stream.passTime(1000);
      if (stream.newest !== old) stream.close(gone('not yet'));
      stream.scheduler.onSignOfLife(old, stream.now);
    }
    stream.answer(outcome(1), old);
    assert.deepEqual(stream.taken(), ['1 RESULT']);
    stream.passTime(3000);
    assert.equal(stream.scheduler.admission(), 'OPEN');
  });

  it('may last if there is no limit', () => {
    const stream = new StreamHarness({addresses: ['a'], frameTimeoutMs: 86_400_000});
    stream.send();
    for (let i = 0; i < 20; ++i) {
      stream.passTime(3_600_000);
      stream.close(gone());
    }
    assert.deepEqual(stream.taken(), []);
  });

  it('fails frames at once if they shall not wait for a server', () => {
    const stream = new StreamHarness({waitForServer: false});
    stream.send();
    for (let i = 0; i < 2; ++i) {
      stream.act();
      assert.deepEqual(stream.taken(), []);
      stream.close(gone());
    }
    stream.act();
    assert.deepEqual(stream.taken(), ['1 FAILED']);
    assert.equal(stream.last.error.code, 'UNAVAILABLE');
  });

  it('is not waited for if TLS is the cause', () => {
    const stream = new StreamHarness({addresses: ['a']});
    stream.send();
    stream.act();
    stream.close(new TlsError('not believed'));
    stream.act();
    assert.deepEqual(stream.taken(), ['1 FAILED']);
    assert.ok(stream.last.error instanceof TlsError);
  });
});

describe('a server that drains', () => {
  it('finishes its frames, and gets no new ones', () => {
    const stream = withOneFrame({maxWaiting: 3});
    const old = stream.newest;
    stream.answer(DRAINING);
    stream.send();
    assert.equal(stream.begun(old), 0);
    assert.ok(stream.scheduler.wantsHalfClose(old));
    stream.open();
    assert.notEqual(stream.newest, old);
    assert.equal(stream.begun(), 1);
    stream.end(1, undefined, old);
    stream.end(1);
    assert.deepEqual(stream.taken(), ['1 RESULT', '2 RESULT']);
    assert.equal(stream.last.report.attempts, 1);
  });

  it('gives the frames that it refuses to the next', () => {
    const stream = withOneFrame();
    stream.answer(DRAINING);
    stream.fail(1, new SegserveError('UNAVAILABLE', 'stopping', {reason: 'DRAINING', retryDelayMs: 1}));
    stream.passTime(100);
    stream.open();
    assert.equal(stream.begun(), 1);
  });

  it('because a token is over may accept the next token', () => {
    const stream = withOneFrame();
    const old = stream.newest;
    stream.answer(DRAINING);
    const over = new SegserveError('UNAUTHENTICATED', 'the token is over');
    stream.fail(1, over);
    stream.close(over, old);
    stream.open();
    assert.notEqual(stream.newest, old);
    assert.equal(stream.begun(), 1);
    stream.end(1);
    assert.deepEqual(stream.taken(), ['1 RESULT']);
  });
});

describe('an old connection', () => {
  it('takes frames until there is another', () => {
    const stream = withOneFrame({maxWaiting: 5});
    const old = stream.newest;
    stream.answer(OLD);
    stream.act();
    assert.deepEqual(stream.kinds, ['OPEN', 'RENEW', 'OPEN']);
    assert.deepEqual([stream.actions[1].connection, stream.actions[2].address], [old, 1]);
    stream.send();
    assert.equal(stream.begun(old), 1, 'nothing waits for the new connection');
    assert.ok(!stream.scheduler.wantsHalfClose(old));
    stream.open();
    stream.send();
    assert.equal(stream.begun(old), 0);
    assert.ok(stream.scheduler.wantsHalfClose(old));
    assert.equal(stream.begun(), 1);
    for (const number of [1, 2]) stream.end(number, undefined, old);
    stream.close(undefined, old);
    stream.end(1);
    assert.deepEqual(stream.taken(), ['1 RESULT', '2 RESULT', '3 RESULT']);
    assert.equal(stream.last.report.attempts, 1);
  });

  it('serves while no other can be made', () => {
    const stream = new StreamHarness({addresses: ['a'], maxWaiting: 5, waitForServer: false});
    stream.open();
    const old = stream.newest;
    stream.answer(OLD);
    stream.act();
    assert.notEqual(stream.newest, old);
    stream.close(gone('no more connections'));
    stream.send();
    stream.act();
    assert.deepEqual(stream.taken(), [], 'the old connection is in reach');
    assert.equal(stream.begun(old), 1);
    stream.end(1, undefined, old);
    assert.deepEqual(stream.taken(), ['1 RESULT']);
    stream.passTime(1000);
    assert.equal(stream.connections.length, 3, 'it tries again');
  });

  it('of a server that stops is left', () => {
    const stream = new StreamHarness({maxWaiting: 5});
    stream.open();
    const old = stream.newest;
    stream.answer(OLD);
    stream.answer(DRAINING);
    stream.send();
    assert.equal(stream.begun(old), 0);
    assert.ok(stream.scheduler.wantsHalfClose(old));
    stream.open();
    assert.equal(stream.begun(), 1);
  });
});

describe('a frame that a server refuses', () => {
  it('fails if that was asked for', () => {
    const stream = withOneFrame({whenBehind: 'reject'});
    stream.fail(1, new SegserveError('RESOURCE_EXHAUSTED', 'full'));
    assert.deepEqual(stream.taken(), ['1 FAILED']);
  });

  it('waits as long as the server asks', () => {
    const stream = withOneFrame();
    stream.fail(1, new SegserveError('RESOURCE_EXHAUSTED', 'full', {reason: 'QUEUE_FULL', retryDelayMs: 3000}));
    stream.passTime(2750);
    assert.equal(stream.begun(), 0);
    stream.passTime(250);
    assert.equal(stream.begun(), 1);
  });

  it('is not tried again beyond a limit', () => {
    const stream = withOneFrame();
    stream.fail(1, new SegserveError('RESOURCE_EXHAUSTED', 'large', {reason: 'LIMIT_EXCEEDED'}));
    assert.deepEqual(stream.taken(), ['1 FAILED']);
    assert.equal(stream.last.error.reason, 'LIMIT_EXCEEDED');
  });
});

describe('a silent connection', () => {
  it('is probed and then given up', () => {
    const stream = withOneFrame({progressTimeoutMs: 1000});
    stream.passTime(500);
    assert.equal(stream.kinds.at(-1), 'PROBE');
    stream.scheduler.onSignOfLife(stream.newest, stream.now);
    stream.passTime(500);
    assert.equal(stream.kinds.at(-1), 'PROBE');
    stream.passTime(500);
    assert.deepEqual(stream.kinds.slice(3), ['BREAK_SILENT', 'OPEN']);
    assert.equal(stream.actions.at(-1).address, 1);
  });

  it('owes nothing while it is idle', () => {
    const stream = new StreamHarness({progressTimeoutMs: 1000});
    stream.open();
    stream.passTime(60_000);
    assert.equal(stream.actions.length, 1);
  });
});

describe('the end', () => {
  it('comes by an error that every server would repeat', () => {
    for (const code of ['INVALID_ARGUMENT', 'UNAUTHENTICATED']) {
      const stream = withOneFrame();
      const error = new SegserveError(code, 'no');
      stream.close(error);
      assert.deepEqual(stream.taken(), ['1 FAILED']);
      assert.equal(stream.scheduler.admission(), 'REFUSED');
      assert.equal(stream.scheduler.refusal(), error);
      assert.ok(stream.scheduler.exhausted());
      stream.act();
      assert.equal(stream.connections.length, 1);
    }
  });

  it('of a server that breaks the protocol is not that of the stream', () => {
    const stream = withOneFrame();
    stream.answer(outcome(5));
    stream.act();
    assert.deepEqual(stream.kinds, ['OPEN', 'BREAK', 'OPEN']);
  });

  it('is a half close after the last outcome', () => {
    const stream = withOneFrame();
    stream.scheduler.finishSending();
    stream.act();
    assert.ok(!stream.scheduler.wantsHalfClose(stream.newest));
    stream.end(1);
    stream.act();
    assert.ok(stream.scheduler.wantsHalfClose(stream.newest));
    assert.ok(!stream.scheduler.exhausted());
    assert.equal(stream.taken().length, 1);
    assert.ok(stream.scheduler.exhausted());
    stream.close();
    stream.passTime(10_000);
    assert.equal(stream.connections.length, 1);
  });

  it('by close() cancels what is unfinished', () => {
    const stream = withOneFrame();
    stream.scheduler.close(stream.now);
    assert.deepEqual(stream.taken(), ['1 CANCELLED']);
    stream.act();
    assert.equal(stream.kinds.at(-1), 'BREAK');
  });
});
