// SPDX-License-Identifier: Apache-2.0
// How a stream hands the state of objects from frame to frame. The test is the clock, the transport and the servers.
import assert from 'node:assert/strict';
import {describe, it} from 'node:test';
import {ours} from './package.js';
import {announced, chunk, DRAINING, outcome, StreamHarness} from './stream_harness.js';

const {SegserveError} = await ours('errors');
const {OutcomeKind} = await ours('gen/segserve/v1/stream_pb');

const ofText = (text) => new TextEncoder().encode(text);
const textOf = (bytes) => new TextDecoder().decode(bytes);

function following(rules = {}) {
  const stream = new StreamHarness({maxWaiting: 10, track: {keepLost: 7}, ...rules});
  stream.open();
  return stream;
}

/** The states of the frames that begin now. */
function begun(stream) {
  return stream.sent().filter((message) => message.case === 'frame').map(({value}) => textOf(value.tracking.state));
}

function finish(stream, number, state, connection) {
  stream.answer(outcome(number, OutcomeKind.RESULT, {result: {tracking: {state: ofText(state)}}}), connection);
}

describe('a stream that follows objects', () => {
  it('sends one frame at a time, with the state of the one before', () => {
    const stream = following();
    for (let i = 0; i < 3; ++i) stream.send();
    const [{value: {tracking}}] = stream.sent().filter((message) => message.case === 'frame');
    assert.deepEqual([tracking.state.length, tracking.keepLost, tracking.time], [0, 7, stream.now / 1000]);
    assert.deepEqual(begun(stream), []);
    finish(stream, 1, 'after 1');
    assert.deepEqual(begun(stream), ['after 1']);
    finish(stream, 2, 'after 2');
    assert.deepEqual(begun(stream), ['after 2']);
  });

  it('begins with a state that was saved', () => {
    const stream = following({track: {state: ofText('saved')}});
    stream.send();
    assert.deepEqual(begun(stream), ['saved']);
  });

  it('goes on from the last result when a frame ends without one', () => {
    const stream = following();
    for (let i = 0; i < 5; ++i) stream.send();
    begun(stream);
    finish(stream, 1, 'after 1');
    begun(stream);
    stream.fail(2, new SegserveError('INVALID_ARGUMENT', 'a bad cloud', {reason: 'INVALID_FIELD'}));
    assert.deepEqual(begun(stream), ['after 1']);
    stream.scheduler.cancel(3, stream.now);
    stream.sent();
    stream.end(3, OutcomeKind.CANCELLED);
    assert.deepEqual(begun(stream), ['after 1']);
    stream.end(4, OutcomeKind.EXPIRED);
    assert.deepEqual(begun(stream), ['after 1']);
    assert.deepEqual(stream.taken(), ['1 RESULT', '2 FAILED', '3 CANCELLED', '4 FAILED']);
  });

  it('goes on from the last result when frames are dropped', () => {
    const stream = following({whenBehind: 'drop_oldest', maxWaiting: 1});
    stream.send();
    begun(stream);
    for (let i = 0; i < 3; ++i) stream.send();
    finish(stream, 1, 'after 1');
    assert.deepEqual(begun(stream), ['after 1']);
    finish(stream, 2, 'after 4');  // the second on the wire
    assert.deepEqual(stream.taken(), ['1 RESULT', '2 DROPPED', '3 DROPPED', '4 RESULT']);
  });

  it('takes no state of a frame whose time was over', () => {
    const stream = following();
    stream.send({timeoutMs: 100});
    stream.send();
    begun(stream);
    stream.passTime(100);
    finish(stream, 1, 'too late');
    assert.deepEqual(begun(stream), ['']);
    assert.deepEqual(stream.taken(), ['1 FAILED']);
  });

  it('lets no frame overtake one that is sent again', () => {
    const stream = following();
    stream.send();
    stream.send({priority: 5});
    begun(stream);
    finish(stream, 1, 'after 1');
    assert.deepEqual(begun(stream), ['after 1']);
    stream.send({priority: 9});
    stream.fail(2, new SegserveError('UNAVAILABLE', 'busy'));
    stream.act();
    assert.deepEqual(begun(stream), [], 'frame 2 waits before it is sent again, and frame 3 waits for it');
    stream.passTime(1000);
    const again = stream.sent().filter((message) => message.case === 'frame').map(({value}) => value);
    assert.deepEqual(again.map(({priority, tracking}) => [priority, textOf(tracking.state)]), [[5, 'after 1']]);
  });

  it('takes no state of a result that was damaged', () => {
    const stream = following();
    stream.send();
    begun(stream);
    const damaged = announced(1, 4, 0);
    stream.answer(damaged);
    stream.answer(chunk(1, ofText('evil')));
    assert.deepEqual(begun(stream), ['']);
  });

  it('waits for the last frame of a server that drains', () => {
    const stream = following();
    stream.send();
    stream.send();
    begun(stream);
    const [old] = stream.connections;
    stream.answer(DRAINING);
    stream.open();
    assert.deepEqual([stream.connections.length, begun(stream)], [2, []]);
    finish(stream, 1, 'after 1', old);
    assert.deepEqual(begun(stream), ['after 1']);
  });

  it('sends the same state again when a server is gone', () => {
    const stream = following();
    for (let i = 0; i < 4; ++i) stream.send();
    begun(stream);
    finish(stream, 1, 'after 1');
    begun(stream);
    stream.close(new SegserveError('UNAVAILABLE', 'gone'));
    stream.open();
    assert.deepEqual([stream.connections.length, begun(stream)], [2, ['after 1']]);
  });

  it('has room for results that nobody takes only as far as the window goes', () => {
    const stream = following({maxInFlight: 2});
    for (let i = 0; i < 3; ++i) stream.send();
    begun(stream);
    finish(stream, 1, 'after 1');
    begun(stream);
    finish(stream, 2, 'after 2');
    assert.deepEqual(begun(stream), []);
    stream.taken();
    assert.deepEqual(begun(stream), ['after 2']);
  });
});
