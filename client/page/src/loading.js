// SPDX-License-Identifier: Apache-2.0
// Makes clouds and sides of the data that segctl view wrote into the page, or that a server answered.
import {MergeTree} from './merge_tree.js';
import {readArrays} from './page_data.js';
import {drawingOrder, interleave} from './point_order.js';
import {Side} from './side.js';

/** The middle of most of the points, and how far they reach from it. */
function extentOf(positions) {
  const sample = [0, 1, 2].map((axis) => {
    const values = [];
    const step = 3 * Math.max(1, Math.floor(positions.length / 60_000));
    for (let i = axis; i < positions.length; i += step) values.push(positions[i]);
    return Float32Array.from(values).sort();
  });
  const at = (share) => sample.map((values) => values[Math.floor(share * (values.length - 1))] ?? 0);
  const [low, high] = [at(0.02), at(0.98)];
  const size = Math.hypot(...low.map((v, k) => high[k] - v));
  return {center: low.map((v, k) => (v + high[k]) / 2), radius: Math.max(1e-3, size / 2)};
}

async function loadCloud(description, textOf) {
  const {x, y, z, red, green, blue, truth} = await readArrays(description.arrays, textOf);
  const order = drawingOrder(x.length);
  const positions = interleave([x, y, z], order);
  return {
    ...description,
    order,
    positions,
    points: x.length,
    rgb: red && interleave([red, green, blue], order),
    truth: truth && interleave([truth], order),
    truthLabels: description.truth_labels ?? [],
    isCameraView: description.view === 'camera',
    ...extentOf(positions),
  };
}

async function loadSide(description, clouds, textOf) {
  const arrays = await readArrays(description.arrays, textOf);
  const cloud = clouds[description.cloud];
  const tree = new MergeTree({leafPoints: arrays.leaf_points, left: arrays.left, right: arrays.right,
                              weight: arrays.weight, mergedRows: description.merged_rows});
  const supervoxel = interleave([arrays.supervoxel], cloud.order);
  const {name, method, threshold, regions} = description;
  return new Side({name, method, threshold, regions, tree, supervoxel, cloud, edges: arrays.edges,
                   normals: arrays.normals});
}

/** Reads the page's data: {title, sides}. `textOf` gives the text of an array by its id. */
export async function load(data, textOf) {
  const clouds = [];
  for (const cloud of data.clouds) clouds.push(await loadCloud(cloud, textOf));
  const sides = [];
  for (const result of data.results) sides.push(await loadSide(result, clouds, textOf));
  if (sides.length === 2 && sides[0].cloud === sides[1].cloud) sides[1].matchColors(sides[0]);
  return {title: data.title, sides};
}
