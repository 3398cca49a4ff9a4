// SPDX-License-Identifier: Apache-2.0
// What one must know: findings in words, the key figures, and which objectives were met.
import {element} from '../src/dom.js';
import {fixed, isNumber, latency, rate, share, text, whole} from './figures.js';
import {numbers, table, texts} from './table.js';

export const errorShare = ({sent, results}) => sent > 0 ? 100 * (sent - results) / sent : null;

function tile(key, title, shown, value, note) {
  const made = element('div', {class: 'tile', 'data-key': key}, element('span', {}, title), element('b', {}, shown));
  if (isNumber(value)) made.dataset.value = String(value);
  if (note) made.append(element('span', {}, note));
  return made;
}

function tiles(run) {
  const {frames, latency_ms: ms, latency_beyond: beyond} = run;
  const achieved = run.achieved_frames_per_s ?? run.frames_per_s ?? null;
  const offered = run.offered_frames_per_s ?? null;
  const of = (name) => tile(`latency_ms.${name}`, `${name} latency, ms`, latency(ms[name], name, beyond), ms[name],
                            beyond?.includes(name) ? 'it falls among failed frames' : undefined);
  const failed = errorShare(frames);
  const made = [
    tile('achieved_frames_per_s', 'Throughput, frames/s', rate(achieved), achieved,
         offered === null ? `closed loop of ${run.clients} clients` : `of ${rate(offered)} offered`),
    of('p50'), of('p99'),
    tile('errors_percent', 'Frames without a result', share(failed), failed, `${whole(frames.sent - frames.results)} of ${whole(frames.sent)}`),
  ];
  if (isNumber(run.mpoints_per_s)) made.push(tile('mpoints_per_s', 'Million points a second', fixed(2)(run.mpoints_per_s), run.mpoints_per_s));
  if (isNumber(run.client_cpu_ms_per_frame)) {
    made.push(tile('client_cpu_ms_per_frame', 'CPU of segctl, ms a frame', fixed(2)(run.client_cpu_ms_per_frame), run.client_cpu_ms_per_frame,
                   isNumber(run.client_busy_cpus) ? `${fixed(2)(run.client_busy_cpus)} CPUs busy` : undefined));
  }
  const cpu = run.server_metrics?.cpu_ms_per_frame;
  if (isNumber(cpu)) made.push(tile('server_metrics.cpu_ms_per_frame', 'CPU of the server, ms a frame', fixed(2)(cpu), cpu));
  return element('div', {class: 'tiles'}, ...made);
}

function findings(run) {
  const list = element('ul', {class: 'findings', id: 'findings'});
  for (const {code, text: sentence} of run.findings ?? []) list.append(element('li', {}, element('b', {}, code), sentence));
  if (list.childElementCount === 0) list.append(element('li', {class: 'fine'}, 'Nothing speaks against these figures.'));
  return list;
}

const verdict = (met) => met ? 'met' : 'MISSED';

function objectives(run) {
  if (!run.objectives?.length) return [];
  const rows = table('objectives', 'Objectives', [texts('Objective', 'objective'), numbers('Reached', 'value', fixed(3)),
                                                  {title: '', of: ({met}) => verdict(met), isText: true}], run.objectives);
  for (const cell of rows.querySelectorAll('td:last-child')) cell.classList.add(cell.textContent === 'met' ? 'met' : 'missed');
  return [rows];
}

/** What a search has found, in words. */
export function searchText({objective, capacity_frames_per_s: capacity, high, tries}) {
  const missed = isNumber(high) ? `${rate(high)} frames/s missed it` : 'none missed it';
  const found = isNumber(capacity) ? `${rate(capacity)} frames/s met ${text(objective)}, and ${missed}` : `No rate met ${text(objective)}`;
  return `${found}.` + (Array.isArray(tries) ? ` The search took ${whole(tries.length)} tries.` : '');
}

const search = (run) => run.search ? [element('p', {id: 'search'}, searchText(run.search))] : [];

export const overview = (run) => [findings(run), tiles(run), ...search(run), ...objectives(run)];
