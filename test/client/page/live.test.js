// SPDX-License-Identifier: Apache-2.0
import assert from 'node:assert/strict';
import {test} from 'node:test';
import {figures} from '../../../client/page/src/live.js';
import {MergeTree} from '../../../client/page/src/merge_tree.js';
import {PlaceGrid} from '../../../client/page/src/nearest.js';
import {Side} from '../../../client/page/src/side.js';

test('the nearest place is found as by looking at all', () => {
  let seed = 7;
  const random = () => { seed = (seed * 48271) % 2147483647; return seed / 2147483647; };
  const places = Float32Array.from({length: 300}, random);
  const reach = 0.12, grid = new PlaceGrid(places, reach);
  for (let i = 0; i < 500; ++i) {
    const at = [random(), random(), random()];
    let best, least = reach;
    for (let k = 0; k < 100; ++k) {
      const distance = Math.hypot(...at.map((v, axis) => places[3 * k + axis] - v));
      if (distance <= least) [best, least] = [k, distance];
    }
    assert.equal(grid.nearest(...at), best);
  }
});

test('figures of a stream are a line', () => {
  const stats = {results: 12, rate: 9.96, p50_ms: 31.25, p95_ms: null, dropped: 3, failed: 0};
  assert.equal(figures(stats), '12 results · 10.0 a second · p50 31.3 ms · p95 – ms · 3 dropped');
  assert.match(figures({...stats, failed: 2}), / · 2 failed$/);
  assert.match(figures({...stats, late: 4}), / · 4 sent late$/);
});

/** Things of four supervoxels each, at these places; each thing is a segment at the threshold 0.5. */
function sceneOf(places) {
  const positions = [], supervoxel = [], leafPoints = [], left = [], right = [], weight = [], edges = [];
  places.forEach(([x, y, z], thing) => {
    for (let i = 0; i < 4; ++i) {
      positions.push(x + 0.01 * i, y, z);
      supervoxel.push(4 * thing + i + 1);
      leafPoints.push(100 - thing);
      if (i > 0) edges.push(4 * thing + i - 1, 4 * thing + i);
    }
  });
  const leaves = leafPoints.length;
  let node = leaves;
  const roots = places.map((_, thing) => {
    let root = 4 * thing;
    for (let i = 1; i < 4; ++i) {
      left.push(Math.min(root, 4 * thing + i));
      right.push(Math.max(root, 4 * thing + i));
      weight.push(0.1);
      root = node++;
    }
    return root;
  });
  roots.reduce((a, b) => {
    left.push(Math.min(a, b));
    right.push(Math.max(a, b));
    weight.push(0.9);
    return node++;
  });
  const tree = new MergeTree({leafPoints, left, right, weight, mergedRows: left.length});
  const cloud = {positions: Float32Array.from(positions), points: supervoxel.length, radius: 1, isCameraView: true};
  return new Side({name: '', method: '', threshold: 0.5, regions: null, tree, cloud, edges: Uint32Array.from(edges),
                   supervoxel: Uint32Array.from(supervoxel)});
}

test('segments keep their colors from frame to frame, whatever their numbers', () => {
  const places = Array.from({length: 8}, (_, i) => [0.3 * i, 0, 1]);
  const before = sceneOf(places);
  const moved = places.map(([x, y, z]) => [x + 0.02, y - 0.01, z]).reverse();
  const after = sceneOf(moved);
  after.matchNear(before);
  const colorOf = (side, thing) => side.rgbOfNode(side.nodeOfPoint(4 * thing)).join();
  const colors = places.map((_, thing) => colorOf(before, thing));
  assert.ok(new Set(colors).size > 4);
  places.forEach((_, thing) => assert.equal(colorOf(after, 7 - thing), colors[thing]));
  // A thing that is new takes no color away.
  const more = sceneOf([[0, 0.9, 1], ...moved]);
  more.matchNear(after);
  places.forEach((_, thing) => assert.equal(colorOf(more, 8 - thing), colors[thing]));
});
