// SPDX-License-Identifier: Apache-2.0
import assert from 'node:assert/strict';
import {test} from 'node:test';
import {bytes, latency, milliseconds} from '../../../client/page/bench/figures.js';
import {percentOf, percentileCurve, quantile} from '../../../client/page/bench/histogram.js';
import {searchText} from '../../../client/page/bench/overview.js';
import {parts, sums} from '../../../client/page/bench/split.js';

test('a percentile curve has a step for each bucket and ends at its largest value', () => {
  const curve = percentileCurve({buckets: [[1000, 50], [2000, 0], [3000, 49], [9000, 1]], failed: 0});
  assert.deepEqual(curve, {x: [1, 2, 100, 100], ms: [1, 3, 9, 9]});
});

test('failed frames are infinitely late, so that the curve ends at their share', () => {
  const {x, ms} = percentileCurve({buckets: [[1000, 90]], failed: 10});
  assert.deepEqual([x, ms], [[1, 10], [1, 1]]);
  assert.deepEqual(percentileCurve({buckets: [], failed: 10}), {x: [], ms: []});
});

test('a quantile is the nearest rank, and none among failed frames', () => {
  const histogram = {buckets: [[1000, 1], [2000, 2], [5000, 6]], failed: 1};
  assert.deepEqual([0.05, 0.1, 0.11, 0.3, 0.31, 0.9, 0.91].map((q) => quantile(histogram, q)), [1, 1, 2, 2, 5, 5, null]);
  assert.equal(quantile({buckets: [[7, 1000]]}, 0.999), 0.007);
});

test('places on the axis are named by the percentile', () => {
  assert.deepEqual([1, 2, 10, 20, 100, 1000, 10_000].map(percentOf),
                   ['0 %', '50 %', '90 %', '95 %', '99 %', '99.9 %', '99.99 %']);
});

test('the parts of a frame add up in their groups', () => {
  const stages = {client_encode: 1, client_wait: 2, queue: 4, decode: 8, voxels: 16, later: 32, client_decode: 64, rest: null, total: 127};
  assert.deepEqual(sums(stages), {client: 67, queue: 4, server: 56, transport: 0});
  assert.equal(parts(stages).length, 8);
});

test('a search is told with its tries, and that no rate met the objective', () => {
  const objective = 'p99<50ms', tries = [{offered_frames_per_s: 40, met: true}, {offered_frames_per_s: 41, met: false}];
  assert.equal(searchText({objective, capacity_frames_per_s: 40, low: 40, high: 41, tries}),
               '40.0 frames/s met p99<50ms, and 41.0 frames/s missed it. The search took 2 tries.');
  assert.equal(searchText({objective, capacity_frames_per_s: null, low: 0, high: 1, tries}),
               'No rate met p99<50ms. The search took 2 tries.');
  assert.equal(searchText({objective, capacity_frames_per_s: 40, low: 40, high: null}), '40.0 frames/s met p99<50ms, and none missed it.');
});

test('figures are short', () => {
  assert.deepEqual([0.1234, 1.234, 12.34, 1234.5, null, NaN].map(milliseconds), ['0.123', '1.23', '12.3', '1,235', '–', '–']);
  assert.deepEqual([0, 999, 4_608_100, null].map(bytes), ['0 B', '999 B', '4.61 MB', '–']);
  assert.deepEqual([latency(null, 'p99', ['p99']), latency(5, 'p99', []), latency(null, 'p99', undefined)], ['∞', '5.00', '–']);
});
