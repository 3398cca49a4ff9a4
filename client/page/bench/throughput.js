// SPDX-License-Identifier: Apache-2.0
// Frames a second over time, and against the load that was offered.
import uPlot from 'uplot';
import {element} from '../src/dom.js';
import {WHOLE, X_SECONDS, chart, line, needsLogarithm} from './chart.js';
import {bytes, fixed, isNumber, milliseconds, rate, whole} from './figures.js';
import {figuresOf, numbers, table, texts} from './table.js';

function overTime({timeline}) {
  const step = timeline.length > 1 ? timeline[1].t - timeline[0].t || 1 : 1;
  const times = timeline.map((entry) => entry.t);
  // Frames of an entry for each of its seconds.
  const of = (key) => timeline.map((entry) => isNumber(entry[key]) ? entry[key] / (entry.seconds || step) : null);
  return chart('throughput', 'Throughput over time', {
    x: X_SECONDS, y: {label: 'frames/s', format: String}, data: [times, of('offered'), of('sent'), of('results'), of('failed')],
    lines: [line('offered', 'offered', rate, {dash: [2, 3]}), line('sent', 'sent', rate, {dash: [8, 3]}),
            line('results', 'results', rate, {width: 2.25}), line('failed', 'failed', rate, {dash: [4, 2]})],
    figures: figuresOf('throughput-timeline', 'Frames, and what this process used, over time', [
      numbers('t, s', 't', String), numbers('offered', 'offered', whole), numbers('sent', 'sent', whole), numbers('results', 'results', whole),
      numbers('failed', 'failed', whole), numbers('sent late', 'late', whole), numbers('CPUs busy', 'client_busy_cpus', fixed(2)),
      numbers('memory', 'client_rss_bytes', bytes)], timeline),
  });
}

/** How the points are told apart: by the rate that was offered, or in a closed loop by the clients. */
function loadAxis(points) {
  const isOpen = points.every((point) => isNumber(point.offered_frames_per_s));
  const key = isOpen ? 'offered_frames_per_s' : 'clients';
  return {key, isOpen, label: isOpen ? 'offered frames/s' : 'clients', format: isOpen ? rate : whole};
}

/** Lines that are told apart by color and, beyond the fifth, by dashes, too. */
const TONES = ['results', 'p50', 'p99', 'client', 'max'];
const styleOf = (index) => ({tone: TONES[index % TONES.length], dash: [undefined, [8, 3], [3, 3]][Math.floor(index / TONES.length) % 3]});

/** The points of each codec, in the order of the load. Those without one are a series of their own. */
function seriesOf(points, key) {
  const series = new Map();
  for (const point of points.filter((p) => isNumber(p[key])).sort((a, b) => a[key] - b[key])) {
    const name = point.codec ?? '';
    if (!series.has(name)) series.set(name, []);
    series.get(name).push(point);
  }
  return [...series];
}

/** A chart with a line for each of the readings {label, of, dash} of each series. */
function loadChart(name, title, x, y, series, readings, more) {
  const lines = [], tables = [];
  series.forEach(([codec, points], index) => {
    for (const {label, of, dash: ownDash} of readings) {
      const {tone, dash} = series.length > 1 ? styleOf(index) : {tone: label === 'p99' ? 'p99' : 'results'};
      lines.push(line([codec, label].filter(Boolean).join(', '), tone, y.format ?? milliseconds, {hasPoints: true, dash: ownDash ?? dash}));
      tables.push([points.map((point) => point[x.key]), points.map((point) => of(point) ?? null)]);
    }
  });
  for (const each of lines) each.spanGaps = true;  // Another codec may have loads in between.
  const values = tables.map(([, list]) => list);
  return chart(name, title, {
    x: {label: x.label, format: String, show: x.format, axis: x.isOpen ? {} : WHOLE},
    y: {...y, isLogarithmic: !y.format && needsLogarithm(values)}, data: uPlot.join(tables), lines, ...more});
}

function byLoad(points) {
  const x = loadAxis(points), series = seriesOf(points, x.key);
  const against = `against ${x.isOpen ? 'offered load' : 'the number of clients'}`;
  const offered = x.isOpen && series.length === 1 ? [{label: 'offered', of: (point) => point.offered_frames_per_s, dash: [2, 3]}] : [];
  const latencies = [{label: 'p50', of: (point) => point.latency_ms?.p50}, {label: 'p99', of: (point) => point.latency_ms?.p99, dash: [4, 3]}];
  return [
    loadChart('load', `Throughput ${against}`, x, {label: 'frames/s', format: rate}, series,
              [{label: series.length > 1 ? '' : 'achieved', of: (point) => point.achieved_frames_per_s}, ...offered],
              {figures: table('points', 'Each load', columns(x), points)}),
    loadChart('load-latency', `Latency ${against}`, x, {label: 'ms'}, series, series.length > 1 ? [{...latencies[1], label: 'p99', dash: undefined}] : latencies,
              {figures: element('p', {class: 'note'}, 'The table above has the figures.')}),
  ];
}

function columns(x) {
  return [
    texts('load', 'label'), numbers('clients', 'clients', whole),
    ...(x.isOpen ? [numbers('offered/s', 'offered_frames_per_s', rate)] : []),
    numbers('frames/s', 'achieved_frames_per_s', rate), numbers('Mpoints/s', 'mpoints_per_s', fixed(2)), numbers('up/s', 'bytes_up_per_s', bytes),
    numbers('p50 ms', (point) => point.latency_ms?.p50, milliseconds), numbers('p99 ms', (point) => point.latency_ms?.p99, milliseconds),
    numbers('failed', 'failed', whole), numbers('least share, %', 'least_share_percent', fixed(0)),
    numbers('server CPU, ms a frame', 'server_cpu_ms_per_frame', fixed(1)), texts('', ({verdict}) => verdict ?? ''),
  ];
}

export function throughputSections(run) {
  const made = [];
  if (run.timeline?.length) made.push(overTime(run));
  if (run.points?.length > 1) made.push(...byLoad(run.points));
  return made.length > 0 ? [element('h2', {}, 'Throughput'), ...made] : [];
}
