// SPDX-License-Identifier: Apache-2.0
// Percentile curves of the histograms in the JSON of segctl bench.

/**
 * The percentile curve of a histogram as steps: from x[i] to x[i + 1] the latency is ms[i]. x is 1 / (1 - q), so that a
 * logarithmic axis gives each further nine of the percentile the same room. Failed frames count as infinitely late: the
 * curve ends at their share.
 */
export function percentileCurve({buckets, failed = 0}) {
  const total = buckets.reduce((sum, [, count]) => sum + count, failed);
  const curve = {x: [], ms: []};
  let below = 0;
  for (const [microseconds, count] of buckets) {
    if (count <= 0) continue;
    curve.x.push(total / (total - below));
    curve.ms.push(microseconds / 1000);
    below += count;
  }
  if (curve.x.length > 0) {
    // The largest of N values stands for the share 1 - 1/N and all above.
    curve.x.push(failed > 0 ? total / failed : Math.max(total, curve.x.at(-1)));
    curve.ms.push(curve.ms.at(-1));
  }
  return curve;
}

/** "99.9 %" for x = 1000, as percentileCurve has it. */
export function percentOf(x) {
  const digits = Math.max(0, Math.ceil(Math.log10(x) - 1e-9) - 2);
  return `${(100 * (1 - 1 / x)).toFixed(Math.min(6, digits))} %`;
}

/** The latency in milliseconds that the share q of all frames, failed ones included, do not exceed; null: it failed. */
export function quantile({buckets, failed = 0}, q) {
  const total = buckets.reduce((sum, [, count]) => sum + count, failed);
  const rank = Math.max(1, Math.ceil(q * total - 1e-9));
  let below = 0;
  for (const [microseconds, count] of buckets) {
    below += count;
    if (below >= rank) return microseconds / 1000;
  }
  return null;
}
