// SPDX-License-Identifier: Apache-2.0
// The order in which points are drawn. A leading part of it is an even sample of the cloud, so that a part can stand for the
// whole while the view moves. Points are taken in strides, because neighbors then stay near each other.

/** So few points are the finest part that is an even sample. */
const PART = 20_000;

/** The numbers below a power of two with their bits reversed: each lies far from those before it. */
function* reversed(power) {
  if (power === 1) return yield 0;
  for (const number of reversed(power / 2)) yield 2 * number;
  for (const number of reversed(power / 2)) yield 2 * number + 1;
}

/** For each place in the input its place in the order. */
export function drawingOrder(count) {
  const stride = 2 ** Math.max(0, Math.ceil(Math.log2(count / PART)));
  const order = new Uint32Array(count);
  let next = 0;
  for (const start of reversed(stride)) {
    for (let i = start; i < count; i += stride) order[i] = next++;
  }
  return order;
}

/** Interleaves columns, which are in the order of the input, as rows in the drawing order. */
export function interleave(columns, order) {
  const width = columns.length;
  const rows = new columns[0].constructor(width * order.length);
  columns.forEach((column, k) => {
    for (let i = 0; i < order.length; ++i) rows[width * order[i] + k] = column[i];
  });
  return rows;
}
