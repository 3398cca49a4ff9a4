// SPDX-License-Identifier: Apache-2.0

/**
 * The points with their colors and labels as a PLY file, binary, in the coordinates of the file that they came from.
 * @param {number[]} order for each row of the file the index of its point, in the order of the input
 * @param {{scale: number[], offset: number[]}} placement cloud = scale * (file - offset), axis by axis
 */
export function encodePly({positions, rgb, order, labelOf, placement}) {
  const isMoved = placement.scale.some((s) => s !== 1) || placement.offset.some((o) => o !== 0);
  const real = isMoved ? 'double' : 'float', realBytes = isMoved ? 8 : 4;
  const header = ['ply', 'format binary_little_endian 1.0', `element vertex ${order.length}`,
                  ...['x', 'y', 'z'].map((axis) => `property ${real} ${axis}`),
                  ...(rgb ? ['red', 'green', 'blue'].map((channel) => `property uchar ${channel}`) : []),
                  'property uint label', 'end_header', ''].join('\n');
  const head = new TextEncoder().encode(header);
  const rowBytes = 3 * realBytes + (rgb ? 3 : 0) + 4;
  const bytes = new Uint8Array(head.length + rowBytes * order.length);
  bytes.set(head);
  const view = new DataView(bytes.buffer);
  let at = head.length;
  for (const point of order) {
    for (let axis = 0; axis < 3; ++axis, at += realBytes) {
      const value = positions[3 * point + axis];
      if (isMoved) view.setFloat64(at, value / placement.scale[axis] + placement.offset[axis], true);
      else view.setFloat32(at, value, true);
    }
    if (rgb) {
      bytes.set(rgb.subarray(3 * point, 3 * point + 3), at);
      at += 3;
    }
    view.setUint32(at, labelOf(point), true);
    at += 4;
  }
  return bytes;
}
