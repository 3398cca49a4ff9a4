// SPDX-License-Identifier: Apache-2.0
// What calls and streams ask for when they follow objects, and the ids in answers.
import assert from 'node:assert/strict';
import {afterEach, beforeEach, describe, it} from 'node:test';
import {FakeServer, resultOf} from './fake_server.js';
import {ours, theirs} from './package.js';

const {create} = await theirs('@bufbuild/protobuf');
const {Client} = await ours('index');
const {fitsMessage, MOST_REQUEST_BYTES} = await ours('requests');
const {TrackEventKind, TrackResultSchema} = await ours('gen/segserve/v1/tracking_pb');
const {tracksOf} = await ours('tracks');

const CLOUD = {xyz: new Float32Array(60).fill(1), width: 5, height: 4, view: 'camera', outputs: ['labels']};
const POSE = [[1, 0, 0, 4], [0, 1, 0, 5], [0, 0, 1, 6]];
const STATE = Uint8Array.of(1, 2, 3);
const followed = (more = {}) => create(TrackResultSchema, {state: Uint8Array.from(STATE), trackIds: [7n], ...more});

let server, client;
beforeEach(async () => {
  server = await FakeServer.start();
  const {result} = server;
  server.result = (request) => ({...result(request), tracking: request.tracking && followed()});
  server.onFrame = (header) => {
    const [outcome, chunk] = resultOf(header);
    outcome.kind.value.result.tracking = followed();
    return [outcome, chunk];
  };
  client = new Client(server.address);
});
afterEach(async () => {
  await client.close();
  server.close();
});

describe('a call that follows objects', () => {
  it('carries what it asks for, and has the ids', async () => {
    const {tracks} = await client.segment({...CLOUD, track: {state: STATE, pose: POSE, time: 2.5, maxSpeed: 3, keepLost: 9, minPoints: 50}});
    assert.deepEqual([tracks.state, tracks.ids, tracks.events], [STATE, [7], []]);
    const [{tracking: {state, pose, time, maxSpeed, keepLost, minPoints}}] = server.requests;
    assert.deepEqual([[...state], time, maxSpeed, keepLost, minPoints], [[1, 2, 3], 2.5, 3, 9, 50]);
    assert.deepEqual([pose.rotation, pose.translation.x, pose.translation.z], [[1, 0, 0, 0, 1, 0, 0, 0, 1], 4, 6]);
  });

  it('needs no rules, and is no other call', async () => {
    assert.deepEqual((await client.segment({...CLOUD, track: true})).tracks.ids, [7]);
    assert.equal((await client.segment({...CLOUD, track: false})).tracks, undefined);
    const [{tracking}, plain] = server.requests;
    assert.deepEqual([tracking.state.length, tracking.pose, tracking.time, tracking.maxSpeed], [0, undefined, undefined, undefined]);
    assert.equal(plain.tracking, undefined);
  });

  it('takes a pose of four rows, also of typed arrays', async () => {
    const rows = [...POSE, [0, 0, 0, 1]].map((row) => Float64Array.from(row));
    await client.segment({...CLOUD, track: {pose: rows}});
    assert.equal(server.requests[0].tracking.pose.translation.y, 5);
  });

  it('refuses what makes no sense before anything is sent', async () => {
    for (const [track, why] of [[{pose: POSE.slice(1)}, /pose: a matrix/], [{pose: [...POSE, [0, 0, 1, 1]]}, /the last row/],
                                [{pose: POSE.flat()}, /pose: a matrix/], [{pose: [[NaN, 0, 0, 0], ...POSE.slice(1)]}, /finite/],
                                [{state: 'x'}, /track\.state/], [{maxSpeed: NaN}, /track\.maxSpeed/], [{keepLost: 0.5}, /track\.keepLost/],
                                [{minPoints: -1}, /track\.minPoints/], [{time: '1'}, /track\.time/], [{states: STATE}, /no 'states'/],
                                ['yes', /true or an object/], [null, /true or an object/]]) {
      await assert.rejects(client.segment({...CLOUD, track}), why);
    }
    assert.equal(server.requests.length, 0);
  });

  it('says that a server is too old for it', async () => {
    server.result = FakeServer.prototype.result;
    await assert.rejects(client.segment({...CLOUD, track: true}), {code: 'UNIMPLEMENTED', message: /older than tracking/});
  });

  it('goes by a stream if cloud and state do not fit into a message', async () => {
    const payload = {size: MOST_REQUEST_BYTES - 50_000};
    assert.ok(fitsMessage({payload}));
    assert.ok(!fitsMessage({payload, tracking: {state: new Uint8Array(60_000)}}));
    const xyz = new Float32Array(3 * 800_000).fill(1);
    const {tracks} = await client.segment({xyz, view: 'camera', codec: 'planar', outputs: ['labels'], track: {state: STATE, pose: POSE}});
    const [{tracking}] = server.headers;
    assert.deepEqual([tracks.ids, [...tracking.state], tracking.pose.translation.x, tracking.time], [[7], [1, 2, 3], 4, undefined]);
  });
});

describe('a stream that follows objects', () => {
  it('tells of each frame when and from where it was captured', async () => {
    const stream = client.stream({view: 'camera', outputs: ['labels'], codec: 'planar', track: {state: STATE, keepLost: 9, pose: POSE}});
    const [x, y, z] = POSE;
    const before = Date.now() / 1000;
    const frames = [{...CLOUD, stamp: new Date(1500), pose: [[...x.slice(0, 3), 8], y, z]}, CLOUD];
    for await (const outcome of stream.map(frames)) assert.deepEqual(outcome.get().tracks.ids, [7]);
    const [first, second] = server.headers.map(({tracking}) => tracking);
    assert.deepEqual([[...first.state], first.time, first.pose.translation.x, first.keepLost], [[1, 2, 3], 1.5, 8, 9]);
    assert.deepEqual([second.pose.translation.x, second.keepLost], [4, 9]);
    assert.ok(second.time > before - 1 && second.time < before + 60, 'a process that restores a state goes on with the same clock');
  });

  it('refuses what makes no sense', async () => {
    assert.throws(() => client.stream({track: {time: 1}}), /track: there is no 'time'/);
    assert.throws(() => client.stream({track: {pose: []}}), RangeError);
    await assert.rejects(client.stream().send({...CLOUD, pose: POSE}), /pose: it is for a stream that was opened with track/);
    await assert.rejects(client.stream({track: true}).send({...CLOUD, pose: [1]}), /pose: a matrix/);
  });
});

describe('the ids in an answer', () => {
  it('are those of segments and points', () => {
    const tracks = tracksOf(followed({trackIds: [3n, 0n, 9n]}), 3);
    assert.deepEqual(tracks.ids, [3, 0, 9]);
    assert.deepEqual(tracks.ofPoints(Uint32Array.of(0, 1, 2, 3, 1)), Float64Array.of(0, 3, 0, 9, 3));
  });

  it('come with what became of objects', () => {
    const {events} = tracksOf(followed({events: [{kind: TrackEventKind.BORN, track: 7n}, {kind: 99, track: 8n},
                                                 {kind: TrackEventKind.MERGED, track: 9n, other: 7n}]}), 1);
    assert.deepEqual(events, [{kind: 'born', track: 7, other: 0}, {kind: 'merged', track: 9, other: 7}]);
  });

  it('have a state of their own, which may be kept', () => {
    const message = followed();
    const {state} = tracksOf(message, 1);
    message.state.fill(0);
    assert.deepEqual(state, Uint8Array.of(1, 2, 3));
  });

  it('are refused if they cannot be', async () => {
    const lies = [[{trackIds: []}, /those of 0 segments, but the result has 1/], [{trackIds: [2n ** 60n]}, /too large/],
                  [{state: new Uint8Array((96 << 10) + 1)}, /at most 98304/]];
    for (const [lie, why] of lies) {
      server.result = (request) => ({...FakeServer.prototype.result(request), tracking: followed(lie)});
      await assert.rejects(client.segment({...CLOUD, track: true}), {code: 'INTERNAL', message: why});
    }
    assert.throws(() => tracksOf(followed({trackIds: [4n, 0n, 0n, 4n]}), 4), /two segments have the same id/);
  });
});
