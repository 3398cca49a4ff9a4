// SPDX-License-Identifier: Apache-2.0
// Latency over time, and its distribution.
import uPlot from 'uplot';
import {element} from '../src/dom.js';
import {X_SECONDS, chart, line, needsLogarithm} from './chart.js';
import {latency, milliseconds} from './figures.js';
import {percentOf, percentileCurve, quantile} from './histogram.js';
import {figuresOf, numbers, table, texts} from './table.js';

const NAMES = ['p50', 'p90', 'p95', 'p99', 'p99.9', 'p99.99', 'max', 'mean'];

/** A table with a row for each of the percentiles. */
function percentiles(run) {
  const since = run.since_sent_ms ?? {}, tooFew = run.too_few_samples_for ?? [];
  const rows = NAMES.filter((name) => name in run.latency_ms);
  return table('latency', 'Milliseconds until the decoded result', [
    texts('', (name) => tooFew.includes(name) ? `${name} (too few samples)` : name),
    numbers('from the intended time of sending', (name) => run.latency_ms[name], (value, name) => latency(value, name, run.latency_beyond)),
    numbers('from the actual time of sending', (name) => since[name], milliseconds),
  ], rows);
}

function overTime({timeline}) {
  const of = (key) => timeline.map((second) => second[key] ?? null);
  const data = [of('t'), of('p50_ms'), of('p90_ms'), of('p99_ms'), of('max_ms')];
  return chart('latency', 'Latency over time', {
    x: X_SECONDS, y: {label: 'ms', isLogarithmic: needsLogarithm(data.slice(1))}, data,
    lines: [line('p50', 'p50', milliseconds, {width: 2.25}), line('p90', 'p90', milliseconds, {dash: [8, 3]}),
            line('p99', 'p99', milliseconds, {dash: [4, 3]}), line('max', 'max', milliseconds, {dash: [1, 3]})],
    note: 'Percentiles of the frames that got their result in that time. Negative times are the warm-up.',
    figures: figuresOf('latency-timeline', 'Milliseconds over time', [
      numbers('t, s', 't', String), numbers('p50', 'p50_ms', milliseconds), numbers('p90', 'p90_ms', milliseconds),
      numbers('p99', 'p99_ms', milliseconds), numbers('max', 'max_ms', milliseconds)], timeline),
  });
}

/** Shares for the table of the curve, up to the last that so many frames can tell. */
function shares(total) {
  return [0.25, 0.5, 0.75, 0.9, 0.95, 0.99, 0.999, 0.9999, 0.99999].filter((q) => q <= 0.9 || total * (1 - q) >= 1);
}

function distribution({latency_histogram: intended, since_sent_histogram: sent}) {
  const curves = [intended, sent].filter((histogram) => histogram?.buckets?.length).map(percentileCurve);
  const data = uPlot.join(curves.map(({x, ms}) => [x, ms]));
  const total = intended.buckets.reduce((sum, [, count]) => sum + count, intended.failed ?? 0);
  const lines = [line('from the intended time', 'p99', milliseconds, {isStepped: true, width: 2.25}),
                 line('from the actual time', 'p50', milliseconds, {isStepped: true, dash: [8, 3]})].slice(0, curves.length);
  for (const each of lines) each.spanGaps = true;  // The two curves have steps at places of their own.
  return chart('percentiles', 'Percentile curve', {
    x: {label: 'share of the frames', name: 'percentile', format: percentOf, isLogarithmic: true,
        axis: {filter: (plot, splits) => splits, splits: (plot, index, low, high) => [1, 2, 10, 100, 1e3, 1e4, 1e5, 1e6].filter((x) => x >= low && x <= high)}},
    y: {label: 'ms', isLogarithmic: needsLogarithm(curves.map(({ms}) => ms))}, data, lines,
    note: intended.failed > 0 ? 'Frames without a result count as infinitely late: the curve ends where they begin.' : undefined,
    figures: figuresOf('percentile-curve', 'Milliseconds that a share of the frames does not exceed', [
      texts('share', (q) => percentOf(1 / (1 - q))), numbers('from the intended time', (q) => quantile(intended, q), milliseconds),
      numbers('from the actual time', (q) => sent?.buckets ? quantile(sent, q) : null, milliseconds)], shares(total)),
  });
}

export function latencySections(run) {
  const made = [element('h2', {}, 'Latency'), percentiles(run)];
  if (run.timeline?.length) made.push(overTime(run));
  if (run.latency_histogram?.buckets?.length) made.push(distribution(run));
  return made;
}
