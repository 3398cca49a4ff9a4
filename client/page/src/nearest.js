// SPDX-License-Identifier: Apache-2.0
// Finds the nearest of many places.

export class PlaceGrid {
  /** `places` has x, y, z of each. What is farther away than `reach` is not found. */
  constructor(places, reach) {
    this.places = places;
    this.reach = reach;
    this.cells = new Map();
    for (let i = 0; 3 * i < places.length; ++i) {
      const key = this.#key(...[0, 1, 2].map((axis) => Math.floor(places[3 * i + axis] / reach)));
      if (this.cells.has(key)) this.cells.get(key).push(i); else this.cells.set(key, [i]);
    }
  }

  #key(x, y, z) { return `${x} ${y} ${z}`; }

  /** The index of the nearest place; undefined if none is within reach. */
  nearest(x, y, z) {
    const [cx, cy, cz] = [x, y, z].map((v) => Math.floor(v / this.reach));
    let best, least = this.reach;
    for (let i = -1; i <= 1; ++i) {
      for (let j = -1; j <= 1; ++j) {
        for (let k = -1; k <= 1; ++k) {
          for (const place of this.cells.get(this.#key(cx + i, cy + j, cz + k)) ?? []) {
            const [px, py, pz] = this.places.subarray(3 * place, 3 * place + 3);
            const distance = Math.hypot(px - x, py - y, pz - z);
            if (distance <= least) [best, least] = [place, distance];
          }
        }
      }
    }
    return best;
  }
}
