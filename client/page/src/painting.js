// SPDX-License-Identifier: Apache-2.0
// Fills the tables of colors from which the points of a pane are drawn.
import {PALETTE} from './colors.js';
import {Emphasis, PaintKind} from './point_material.js';

const NOT_SEGMENTED = [66, 69, 77];

/** The ways to color points. `title` is for people; `kind` says what the graphics card does. */
export const PAINTS = {
  segments: {title: 'Segments', key: '1', kind: PaintKind.SUPERVOXEL},
  original: {title: 'Original', key: '2', kind: PaintKind.OWN},
  supervoxels: {title: 'Supervoxels', key: '3', kind: PaintKind.SUPERVOXEL},
  normals: {title: 'Normals', key: '4', kind: PaintKind.SUPERVOXEL},
  stability: {title: 'Stability', key: '5', kind: PaintKind.SUPERVOXEL},
  truth: {title: 'Ground truth', key: '6', kind: PaintKind.TRUTH},
  errors: {title: 'Errors', key: '7', kind: PaintKind.ERRORS},
};

/** Blue for 0, over green, to yellow for 1: viridis at five places (CC0, N. Smith and S. van der Walt). */
const RAMP = [[68, 1, 84], [59, 82, 139], [33, 145, 140], [94, 201, 98], [253, 231, 37]];

export function rampColor(value) {
  const at = Math.min(Math.max(value, 0), 1) * (RAMP.length - 1);
  const i = Math.min(Math.floor(at), RAMP.length - 2);
  return RAMP[i].map((v, k) => Math.round(v + (at - i) * (RAMP[i + 1][k] - v)));
}

function normalColor(normals, leaf) {
  const n = normals.subarray(3 * leaf, 3 * leaf + 3);
  const length = Math.hypot(...n);
  return length > 0 ? Array.from(n, (v) => Math.round(127.5 * (1 + v / length))) : NOT_SEGMENTED;
}

/** A function that gives the color of a leaf. */
function leafPainter(paint, side) {
  const nodeOf = (leaf) => side.cut.nodes[side.cut.segmentOfLeaf[leaf] - 1];
  switch (paint) {
    case 'supervoxels': return (leaf) => PALETTE[side.colorOfLeaf[leaf]].rgb;
    case 'normals': return (leaf) => normalColor(side.normals, leaf);
    case 'stability': return (leaf) => rampColor(side.tree.stability(nodeOf(leaf)));
    default: return (leaf) => side.rgbOfNode(nodeOf(leaf));
  }
}

/** Paints the supervoxels of a pane, with what is chosen and hovered. `hovered` is a node or undefined. */
export function paintSupervoxels(pane, paint, hovered) {
  const {side} = pane, data = pane.colors.image.data, colorOf = leafPainter(paint, side);
  const hasChosen = side.selection !== undefined;
  data.set([...NOT_SEGMENTED, hasChosen ? Emphasis.DIMMED : Emphasis.USUAL]);
  for (let leaf = 0; leaf < side.tree.leaves; ++leaf) {
    const at = 4 * (leaf + 1);
    [data[at], data[at + 1], data[at + 2]] = colorOf(leaf);
    data[at + 3] = hasChosen ? Emphasis.DIMMED : Emphasis.USUAL;
  }
  const emphasize = (node, alpha) => { for (const leaf of side.tree.leavesBelow(node)) data[4 * leaf + 7] = alpha; };
  side.chosenNodes.forEach((node) => emphasize(node, Emphasis.USUAL));
  if (hovered !== undefined) emphasize(hovered, Emphasis.HOVERED);
  pane.colors.needsUpdate = true;
  pane.material.uniforms.paint.value = PAINTS[paint].kind;
}

/** Tells the graphics card which label each supervoxel's segment stands for. */
export function paintVerdicts(pane) {
  const {label, isMain} = pane.side.truth.compare(pane.side.cut);
  const data = pane.verdicts.image.data;
  label.forEach((l, leaf) => data.set([l & 255, l >> 8, 255 * isMain[leaf], 255], 4 * (leaf + 1)));
  pane.verdicts.needsUpdate = true;
}

/** The colors of the file's labels, of which the first is "not labeled". */
export function paintTruth(pane) {
  const data = pane.truthColors.image.data;
  pane.cloud.truthLabels.forEach((_, i) => {
    data.set([...(i === 0 ? NOT_SEGMENTED : PALETTE[(i * 11) % PALETTE.length].rgb), 255], 4 * i);
  });
  pane.truthColors.needsUpdate = true;
}
