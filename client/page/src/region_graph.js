// SPDX-License-Identifier: Apache-2.0

/**
 * The edges between neighboring supervoxels as lines between their centroids. An edge within a segment is dark; one
 * between two segments has the color of the threshold at which they become one.
 */
export function neighborLines(side, colorOf) {
  const {tree, edges, cut, centroids} = side;
  const corners = new Float32Array(3 * edges.length), colors = new Uint8Array(3 * edges.length);
  for (let e = 0; e < edges.length; e += 2) {
    const [a, b] = [edges[e], edges[e + 1]];
    const isWithin = cut.segmentOfLeaf[a] === cut.segmentOfLeaf[b];
    const color = isWithin ? [70, 76, 88] : colorOf(Math.sqrt(heightOfUnion(tree, a, b)));
    for (const [k, leaf] of [a, b].entries()) {
      corners.set(centroids.subarray(3 * leaf, 3 * leaf + 3), 3 * (e + k));
      colors.set(color, 3 * (e + k));
    }
  }
  return {corners, colors};
}

/** The height of the smallest node that holds both. */
function heightOfUnion(tree, a, b) {
  while (a !== b) {
    if (a < b) a = tree.parent[a]; else b = tree.parent[b];
  }
  return tree.isJoined(a) ? 1 : tree.heightOf(a);
}
