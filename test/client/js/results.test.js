// SPDX-License-Identifier: Apache-2.0
// Results of answers, and answers that lie.
import assert from 'node:assert/strict';
import {before, describe, it} from 'node:test';
import {ours, theirs, useZstd} from './package.js';

const {create, fromBinary, toBinary} = await theirs('@bufbuild/protobuf');
const {bytesOf} = await ours('bytes');
const {decodeResult} = await ours('result_message');
const {neededZstd} = await ours('zstd');
const {Compression} = await ours('gen/segserve/v1/block_pb');
const {ViewKind} = await ours('gen/segserve/v1/cloud_pb');
const {Method} = await ours('gen/segserve/v1/options_pb');
const {SegmentationResultSchema} = await ours('gen/segserve/v1/result_pb');

const numbers = (values, width = 1) => {
  const data = new Uint8Array(values.length * width);
  values.forEach((value, i) => { for (let k = 0; k < width; ++k) data[i * width + k] = value >>> 8 * k; });
  return {count: BigInt(values.length), bytesPerValue: width, data: {data}};
};
const axes = [{x: 1}, {y: 1}, {z: 1}];

/** Six points, of which five are finite and four are segmented, in three supervoxels and two segments. */
function good() {
  return {
    summary: {points: 6n, finitePoints: 5n, segmentedPoints: 4n, voxels: 4n, supervoxels: 3, segments: 2, threshold: 0.4,
              method: Method.LAMBDA_CONVEX, view: {kind: ViewKind.WORLD, sensor: {x: 1, y: 2, z: 3}}, viewRule: 'as asked',
              timings: {mergingMs: 2, totalMs: 7}, resolution: {voxelResolution: 0.008, reason: 'dense'},
              warnings: [{reason: 'TOO_SPARSE', message: 'why'}], supportPlane: {points: 1n, normalZ: 1, offset: 0.5}},
    labels: numbers([1, 1, 2, 1, 0, 0]),
    supervoxels: numbers([1, 1, 3, 2, 0, 0], 2),
    tree: {leafPoints: numbers([2, 1, 1], 4), left: numbers([0, 2]), right: numbers([1, 3]),
           weight: {data: bytesOf(Float64Array.of(0.25, 0.5))}, mergedRows: 2},
    segments: [{points: 3, centroid: {x: 1}, box: {axes}, color: {red: 9}}, {points: 1, box: {axes}, normal: {z: 1}}],
  };
}

/** What is selected by the point 0, and without the point 2. */
function selection() {
  return {include: [{point: 0n, supervoxel: 1}], exclude: [{point: 2n, supervoxel: 3}], smallest: [0], stepGroups: [0], stepNodes: [3],
          candidate: 1, thresholds: {lower: 0.25, upper: 1}};
}

const ALL = ['labels', 'supervoxels', 'tree', 'segments'];

/** `points`: of the cloud; null if only the server knows. */
function read(message, outputs = ALL, points = 6) {
  return decodeResult(create(SegmentationResultSchema, message), {points: points ?? undefined, outputs}, {requestId: 'r'});
}

describe('a result', () => {
  it('is read from a part of a Buffer, as gRPC hands it out', () => {
    const message = create(SegmentationResultSchema, good());
    const buffer = Buffer.concat([Buffer.alloc(3), Buffer.from(toBinary(SegmentationResultSchema, message))]).subarray(3);
    const result = decodeResult(fromBinary(SegmentationResultSchema, buffer), {points: 6, outputs: ALL}, {});
    buffer.fill(0);
    assert.deepEqual([result.labels, result.tree.weight], [Uint32Array.of(1, 1, 2, 1, 0, 0), Float64Array.of(0.25, 0.5)]);
  });

  it('has typed arrays and plain values', () => {
    const result = read(good());
    assert.deepEqual([result.labels, result.supervoxels], [Uint32Array.of(1, 1, 2, 1, 0, 0), Uint32Array.of(1, 1, 3, 2, 0, 0)]);
    assert.deepEqual([result.points, result.finitePoints, result.segmentedPoints, result.segmentCount], [6, 5, 4, 2]);
    assert.deepEqual([result.method, result.threshold, result.regions, result.requestId], ['lambda-convex', 0.4, undefined, 'r']);
    assert.deepEqual([result.view, result.viewRule], [{kind: 'world', sensor: [1, 2, 3]}, 'as asked']);
    assert.deepEqual([result.timingsMs.merging, result.timingsMs.total, result.resolution.reason], [2, 7, 'dense']);
    assert.deepEqual(result.warnings, [{reason: 'TOO_SPARSE', message: 'why'}]);
    assert.deepEqual(result.supportPlane, {points: 1, normal: [0, 0, 1], offset: 0.5});
    const [first, second] = result.segments;
    assert.deepEqual([first.label, first.points, first.centroid, first.color, first.normal], [1, 3, [1, 0, 0], [9, 0, 0], undefined]);
    assert.deepEqual([second.color, second.normal, second.box.axes], [undefined, [0, 0, 1], [[1, 0, 0], [0, 1, 0], [0, 0, 1]]]);
  });

  it('is cut without the server', () => {
    const result = read(good());
    assert.deepEqual(result.cut({threshold: 0.3}), result.labels);
    assert.deepEqual(result.cut({regions: 1}), Uint32Array.of(1, 1, 1, 1, 0, 0));
    assert.deepEqual(result.cut({regions: 3}), Uint32Array.of(1, 1, 3, 2, 0, 0));
    assert.throws(() => read(good(), ['labels']).cut({}), /give either regions or threshold/);
    const labelsOnly = read({...good(), tree: undefined}, ['labels']);
    assert.throws(() => labelsOnly.cut({regions: 1}), /the outputs 'supervoxels' and 'tree' are needed/);
  });

  it('picks what clicks choose', () => {
    const result = read(good());
    const picked = result.select({include: [0], exclude: [2]});
    assert.deepEqual(picked.labels, Uint32Array.of(1, 1, 0, 1, 0, 0));
    assert.deepEqual(picked.candidates.map(({nodes, points, thresholds}) => [nodes, points, thresholds]),
                     [[[0], 2, [0, 0.25]], [[3], 3, [0.25, 1]]]);
    assert.deepEqual(result.select({include: [0], larger: -9}).labels, Uint32Array.of(1, 1, 0, 0, 0, 0));
    assert.deepEqual(result.select({include: [0], larger: 9}).labels, Uint32Array.of(1, 1, 1, 1, 0, 0));
    assert.equal(result.select({include: [0], cut: {threshold: 0.1}}).candidate, 0);
    assert.deepEqual([picked.thresholds, picked.include], [[0.25, 1], [{point: 0, supervoxel: 1, distance: 0}]]);
    for (const [wrong, why] of [[{include: [4]}, /point 4 is not segmented/], [{include: [[9, 0]]}, /the cloud is no image/],
                                [{include: [[0.5, 0]]}, /neither a pixel/], [{include: [0], larger: 0.5}, /larger: 0.5/],
                                [{include: [[0, 0, 0]]}, /needs xyz/], [{include: [6]}, /no point 6; the cloud has 6/],
                                [{include: []}, /nothing is included/], [{include: [0], exclude: [1]}, /both included and excluded/]]) {
      assert.throws(() => result.select(wrong), why);
    }
  });

  it('finds the points of pixels and positions', () => {
    const result = decodeResult(create(SegmentationResultSchema, good()), {points: 6, shape: {width: 3, height: 2}, outputs: ALL}, {});
    assert.deepEqual(result.select({include: [[2, 0]]}).include, [{point: 2, supervoxel: 3, distance: 0}]);
    assert.throws(() => result.select({include: [[3, 0]]}), /pixel 3,0 is outside the image of 3 x 2 pixels/);
    assert.throws(() => result.select({include: [[1, 1]]}), /pixel 1,1 has no segmented point/);
    const xyz = Float32Array.from({length: 18}, (_, i) => Math.floor(i / 3));  // the point k is at (k, k, k)
    assert.deepEqual(result.select({include: [[3, 3, 4]], xyz}).include, [{point: 3, supervoxel: 2, distance: 1}]);
    assert.equal(result.select({include: [[5, 5, 5]], xyz}).include[0].point, 3, 'the points 4 and 5 are not segmented');
    assert.throws(() => result.select({include: [[3, 3, 4]], xyz: xyz.subarray(3)}), /xyz has 5 points/);
  });

  it('has what the prompts of the request select', () => {
    const message = {...good(), selection: selection(), selected: numbers([1, 1, 0, 1, 0, 0])};
    const {selection: {labels, candidates, candidate, thresholds, include}} = read(message);
    const {candidates: ours, ...rest} = read(good()).select({include: [0], exclude: [2]});
    assert.deepEqual([labels, candidate, thresholds, include], [rest.labels, rest.candidate, rest.thresholds, rest.include]);
    assert.deepEqual(candidates.map(({nodes}) => nodes), ours.map(({nodes}) => nodes));
    assert.throws(() => decodeResult(create(SegmentationResultSchema, good()), {outputs: ALL, isPrompted: true}, {}),
                  {code: 'UNIMPLEMENTED'});
  });

  it('may be compressed', async () => {
    await useZstd();
    const message = good();
    const data = neededZstd('x').compress(message.labels.data.data);
    message.labels.data = {compression: Compression.ZSTD, decodedBytes: 6n, data};
    assert.deepEqual(read(message).labels, read(good()).labels);
    message.labels.data = {compression: Compression.ZSTD, decodedBytes: 6n, data: data.subarray(1)};
    assert.throws(() => read(message), {code: 'INTERNAL', message: /labels|Zstandard/});
  });
});

describe('an answer that lies', () => {
  before(useZstd);
  const lies = [
    [(m) => { m.summary = undefined; }, /it has no summary/],
    [(m) => { m.summary.points = 7n; }, /has 7 points, but the cloud has 6/],
    [(m) => { m.summary.segments = 4; }, /contradict each other/],
    [(m) => { m.summary.view = {}; }, /which view was used/],
    [(m) => { m.labels = numbers([1, 1, 2, 1, 0]); }, /labels: has 5 values, but must have 6/],
    [(m) => { m.labels = numbers([1, 1, 3, 1, 0, 0]); }, /labels: holds 3/],
    [(m) => { m.labels.bytesPerValue = 3; }, /has 3 bytes per value/],
    [(m) => { m.labels.data.data = new Uint8Array(5); }, /labels: has 5 bytes, but must have 6/],
    [(m) => { m.labels.data.encodedBytes = 9n; }, /claims 9 encoded bytes, but has 6/],
    [(m) => { m.labels.data.decodedBytes = 2n ** 63n; }, /claims 9223372036854775808 bytes/],
    [(m) => { m.labels.data.compression = 7; }, /compression 7 is unknown/],
    [(m) => { m.labels.data = undefined; }, /labels: it has no data/],
    [(m) => { m.supervoxels = undefined; }, /it lacks supervoxels/],
    [(m) => { m.supervoxels = numbers([4, 1, 3, 2, 0, 0]); }, /supervoxels: holds 4/],
    [(m) => { m.tree.leafPoints = numbers([2, 1, 2]); }, /the sum is 5 points, but must be 4/],
    [(m) => { m.tree.left = numbers([0, 9]); }, /merge tree, row 1/],
    [(m) => { m.tree.weight = undefined; }, /tree.weight: it has no data/],
    [(m) => { m.segments.pop(); }, /has 1 entries, but must have 2/],
    [(m) => { m.segments.reverse(); }, /do not fit the summary/],
    [(m) => { m.segments[0].box = {axes: []}; }, /has 0 axes/],
    [(m) => { m.segments[0].thresholds = {lower: 1, upper: 0.5}; }, /segment 1: thresholds: must be ascending/],
    [(m) => { m.selection = {...selection(), smallest: []}; }, /its candidates are none of the tree/],
    [(m) => { m.selection = {...selection(), stepNodes: [5]}; }, /its candidates are none of the tree/],
    [(m) => { m.selection = {...selection(), stepGroups: [1]}; }, /its candidates are none of the tree/],
    [(m) => { m.selection = {...selection(), candidate: 2}; }, /its candidates are none of the tree/],
    [(m) => { m.selection = {...selection(), thresholds: undefined}; }, /selection: it has no thresholds/],
    [(m) => { m.selection = {...selection(), include: [{point: 6n, supervoxel: 1}]}; }, /point 6 is none of the cloud/],
    [(m) => { m.selection = selection(), m.selected = numbers([2, 0, 0, 0, 0, 0]); }, /selected: holds 2/],
  ];
  for (const [lie, why] of lies) {
    it(`is refused: ${why.source}`, () => {
      const message = good();
      lie(message);
      assert.throws(() => read(message), {name: 'SegserveError', code: 'INTERNAL', message: why});
    });
  }

  it('is not believed beyond a number of points', () => {
    const message = good();
    message.summary.points = 2n ** 40n;
    assert.throws(() => read(message, ALL, null), /at most 100000000 are accepted/);
  });
});
