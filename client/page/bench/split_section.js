// SPDX-License-Identifier: Apache-2.0
// Where the time of a frame goes, for all frames and for those of each codec.
import {element} from '../src/dom.js';
import {bytes, fixed, latency, milliseconds, rate, whole} from './figures.js';
import {GROUPS, parts, sums} from './split.js';
import {numbers, table, texts} from './table.js';

/** A bar whose parts are as wide as their times. Times below zero, which clocks of two machines can give, have no width. */
function bar(label, stages) {
  const all = parts(stages).map((part) => ({...part, ms: Math.max(0, part.ms)}));
  const total = all.reduce((sum, {ms}) => sum + ms, 0);
  const made = element('div', {class: 'bar', role: 'img', 'aria-label': `${label}. The tables below have the figures.`});
  for (const group of Object.keys(GROUPS)) {
    for (const {stage, ms} of all.filter((part) => part.group === group && part.ms > 0)) {
      const piece = element('i', {class: group, title: `${stage}: ${milliseconds(ms)} ms`});
      piece.style.width = `${100 * ms / total}%`;
      made.append(piece);
    }
  }
  return made;
}

const legend = () => element('ul', {class: 'key'}, ...Object.entries(GROUPS).map(([group, name]) =>
  element('li', {}, element('i', {class: group}), name)));

function groupTable(all) {
  return table('split', 'Mean milliseconds of a frame with a result', [
    texts('frames', 'name'), ...Object.entries(GROUPS).map(([group, name]) => numbers(name, ({stages}) => sums(stages)[group], milliseconds)),
    numbers('Total', ({stages}) => stages.total, milliseconds)], all);
}

/** A row for each stage, a column for all frames and each codec. */
function stageTable(all) {
  const stages = [...new Set(all.flatMap((each) => Object.keys(each.stages)))];
  return table('stages', 'Mean milliseconds by stage', [
    texts('stage', (stage) => stage), texts('of', (stage) => stage === 'total' ? '' : GROUPS[parts({[stage]: 0})[0].group]),
    ...all.map((each) => numbers(each.name, (stage) => each.stages[stage], milliseconds))], stages);
}

function codecTable(codecs) {
  return table('codecs', 'By codec', [
    texts('codec', 'codec'), numbers('sent', 'sent', whole), numbers('results', 'results', whole), numbers('failed', 'failed', whole),
    numbers('frames/s', 'frames_per_s', rate), numbers('Mpoints/s', 'mpoints_per_s', fixed(2)),
    ...['p50', 'p99'].map((name) => numbers(`${name} ms`, ({latency_ms: ms}) => ms?.[name], (value, codec) => latency(value, name, codec.latency_beyond))),
    numbers('bytes up a frame', 'bytes_up_per_frame', bytes), numbers('down', 'bytes_down_per_frame', bytes),
    numbers('client CPU, ms a frame', 'client_cpu_ms_per_frame', fixed(2))], codecs);
}

const isMeasured = (stages) => stages && Object.values(stages).some((ms) => ms !== null);

export function splitSection(run) {
  const codecs = run.codecs ?? [];
  const all = [{name: 'all frames', stages: run.stages_ms}, ...(codecs.length > 1 ? codecs.map((c) => ({name: c.codec, stages: c.stages_ms})) : [])]
    .filter(({stages}) => isMeasured(stages));
  const made = [];
  if (all.length > 0) {
    made.push(element('h2', {}, 'Where the time of a frame goes'), legend());
    for (const {name, stages} of all) made.push(element('h3', {}, name), bar(`The split of the time of ${name}`, stages));
    made.push(groupTable(all), element('details', {}, element('summary', {}, 'Each stage'), stageTable(all)));
  }
  if (codecs.length > 0) made.push(element('h2', {}, 'Codecs'), codecTable(codecs));
  return made;
}
