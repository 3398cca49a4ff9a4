// SPDX-License-Identifier: Apache-2.0
import assert from 'node:assert/strict';
import {test} from 'node:test';
import {gzipSync} from 'node:zlib';
import {GroundTruth} from '../../../client/page/src/ground_truth.js';
import {MergeTree} from '../../../client/page/src/merge_tree.js';
import {readArray} from '../../../client/page/src/page_data.js';
import {encodePly} from '../../../client/page/src/ply_file.js';
import {drawingOrder, interleave} from '../../../client/page/src/point_order.js';
import {orientedBoxes, SupervoxelSums} from '../../../client/page/src/statistics.js';
import {randomNumbers} from './random_trees.js';

const textOf = (bytes) => () => gzipSync(bytes).toString('base64');

test('arrays are differences in planes of bytes', async () => {
  // 1, 258, 2: the differences are 1, 257 and -256.
  const planes = Uint8Array.of(1, 1, 0, 0, 1, 255, 0, 0, 255, 0, 0, 255);
  assert.deepEqual([...await readArray({type: 'u32', count: 3, id: 'a'}, textOf(planes))], [1, 258, 2]);
  const narrow = Uint8Array.of(250, 10, 251);
  assert.deepEqual([...await readArray({type: 'u8', count: 3, id: 'a'}, textOf(narrow))], [250, 4, 255]);
  const numbers = Float64Array.of(0.1, -2e300);
  assert.deepEqual(await readArray({type: 'f64', count: 2, id: 'a'}, textOf(new Uint8Array(numbers.buffer))), numbers);
});

test('data of another length are refused', async () => {
  await assert.rejects(readArray({type: 'u8', count: 4, id: 'a'}, textOf(new Uint8Array(3))), /not complete/);
  await assert.rejects(readArray({type: 'u8', count: 2, id: 'a'}, textOf(new Uint8Array(3))), /longer/);
});

test('every leading part of the drawing order is an even sample', () => {
  for (const count of [0, 1, 1000, 50_000, 400_000]) {
    const order = drawingOrder(count);
    assert.deepEqual([...order].sort((a, b) => a - b), [...Array(count).keys()]);
    for (const part of [25_000, 60_000, 150_000].filter((points) => points < count)) {
      const slices = new Array(10).fill(0);
      order.forEach((place, i) => { if (place < part) ++slices[Math.floor(10 * i / count)]; });
      assert.ok(Math.min(...slices) > 0.05 * part && Math.max(...slices) < 0.2 * part, `${slices} of ${part}`);
    }
  }
  assert.deepEqual([...interleave([Uint8Array.of(1, 2), Uint8Array.of(3, 4)], Uint32Array.of(1, 0))], [2, 4, 1, 3]);
});

test('boxes hold all points of a turned block and are as large as it', () => {
  const random = randomNumbers(10), half = [0.5, 0.2, 0.05];
  const turn = ([x, y, z]) => [0.6 * x - 0.8 * y + 3, 0.8 * x + 0.6 * y - 2, z + 1];
  const corners = [-1, 1].flatMap((a) => [-1, 1].flatMap((b) => [-1, 1].map((c) => [a, b, c])));
  const inside = Array.from({length: 4000}, () => [0, 1, 2].map(() => 2 * random() - 1));
  const points = [...corners, ...inside].map((p) => turn(p.map((v, k) => v * half[k])));
  const positions = Float32Array.from(points.flat()), supervoxel = new Uint32Array(points.length).fill(1);
  const rgb = new Uint8Array(3 * points.length).fill(9);
  const described = new SupervoxelSums(positions, rgb, supervoxel, 1).describe([0]);
  assert.equal(described.points, points.length);
  assert.deepEqual(described.color, [9, 9, 9]);
  const [box] = orientedBoxes(positions, supervoxel, Int32Array.of(-1, 0), [described]);
  half.forEach((value, k) => assert.ok(Math.abs(box.halfExtents[k] - value) < 0.02, `${box.halfExtents}`));
  [3, -2, 1].forEach((value, k) => assert.ok(Math.abs(box.center[k] - value) < 0.01));
});

test('errors are points of another object, and parts that are split off', () => {
  const tree = new MergeTree({leafPoints: Uint32Array.of(6, 3, 3), left: Uint32Array.of(0, 2), right: Uint32Array.of(1, 3),
                              weight: Float64Array.of(0.2, 0.6), mergedRows: 2});
  const supervoxel = Uint32Array.of(1, 1, 1, 1, 1, 1, 2, 2, 2, 3, 3, 3);
  const truth = Uint16Array.of(1, 1, 1, 1, 1, 2, 1, 1, 1, 2, 2, 0);
  const errors = new GroundTruth(truth, supervoxel, 3, 3);
  const fine = errors.compare(tree.cut(0));
  assert.deepEqual([...fine.label], [1, 1, 2]);
  assert.deepEqual([...fine.isMain], [1, 0, 1]);
  assert.deepEqual(fine.rates, {right: 7 / 11, leaked: 1 / 11, split: 3 / 11});
  assert.deepEqual(errors.compare(tree.cut(1)).rates, {right: 10 / 11, leaked: 1 / 11, split: 0});
});

test('a PLY file has the points in the order of the input and in the coordinates of their file', () => {
  const bytes = encodePly({positions: Float32Array.of(4, 5, 6, 1, 2, 3), rgb: Uint8Array.of(7, 8, 9, 1, 1, 1),
                           order: Uint32Array.of(1, 0), labelOf: (point) => 10 + point,
                           placement: {scale: [0.5, 0.5, 0.5], offset: [100, 0, 0]}});
  const end = Buffer.from(bytes).indexOf('end_header\n') + 11;
  assert.match(Buffer.from(bytes.subarray(0, end)).toString(), /element vertex 2\nproperty double x/);
  const view = new DataView(bytes.buffer, end);
  assert.equal(bytes.length - end, 2 * (24 + 3 + 4));
  assert.deepEqual([0, 8, 16].map((at) => view.getFloat64(at, true)), [102, 4, 6]);
  assert.equal(view.getUint32(27, true), 11);
});
