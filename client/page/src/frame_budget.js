// SPDX-License-Identifier: Apache-2.0

const LEAST = 50_000, MOST = 1e8;
/** So long may the graphics card take for a frame, ms. */
const SLOW = 40, FAST = 20;

/** Decides how many points are drawn at once, so that the page answers at once on every machine. */
export class FrameBudget {
  points = 400_000;

  /** So many points took this time, ms. */
  took(points, ms) {
    if (ms > SLOW) this.points = Math.max(LEAST, Math.min(points, this.points) * Math.max(0.3, SLOW / ms));
    else if (ms < FAST && points > 0.9 * this.points) this.points = Math.min(MOST, 1.5 * this.points);
  }
}
