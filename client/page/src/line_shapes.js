// SPDX-License-Identifier: Apache-2.0
// Boxes of segments and edges between neighboring supervoxels, as lines.
import * as THREE from 'three';

export function lineSegments({opacity, isOnTop = false}) {
  const material = new THREE.LineBasicMaterial({vertexColors: true, transparent: true, opacity, depthTest: !isOnTop});
  const lines = new THREE.LineSegments(new THREE.BufferGeometry(), material);
  lines.frustumCulled = false;
  lines.visible = false;
  return lines;
}

/** `corners` has x, y, z and `colors` r, g, b of both ends of each line. */
export function setLines(lines, corners, colors) {
  lines.geometry.dispose();
  lines.geometry = new THREE.BufferGeometry();
  lines.geometry.setAttribute('position', new THREE.BufferAttribute(Float32Array.from(corners), 3));
  lines.geometry.setAttribute('color', new THREE.BufferAttribute(Uint8Array.from(colors), 3, true));
}

/** The two ends of the twelve sides of a box. */
export function boxSides({center, axes, halfExtents}) {
  const corner = (signs) => [0, 1, 2].map(
      (i) => center[i] + signs.reduce((sum, sign, k) => sum + sign * halfExtents[k] * axes[k][i], 0));
  const ends = [];
  for (let axis = 0; axis < 3; ++axis) {
    for (const [a, b] of [[-1, -1], [-1, 1], [1, -1], [1, 1]]) {
      const signs = [0, 0, 0];
      [signs[(axis + 1) % 3], signs[(axis + 2) % 3]] = [a, b];
      for (const sign of [-1, 1]) {
        signs[axis] = sign;
        ends.push(...corner(signs));
      }
    }
  }
  return ends;
}
