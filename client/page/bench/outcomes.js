// SPDX-License-Identifier: Apache-2.0
// What became of the frames: errors by reason, and how results spread over clients and servers.
import {element} from '../src/dom.js';
import {fixed, share, whole} from './figures.js';
import {figuresOf, numbers, table, texts} from './table.js';
import {WHOLE, chart, line} from './chart.js';

const SHOWN = 5;

function errors({errors: counts = {}, frames}) {
  const rows = Object.entries(counts).map(([reason, count]) => ({reason, count, percent: frames.sent > 0 ? 100 * count / frames.sent : null}))
    .sort((a, b) => b.count - a.count);
  if (rows.length === 0) return [element('p', {id: 'no-errors'}, 'Every frame got its result.')];
  return [table('errors', 'Frames without a result', [texts('outcome, code and reason', 'reason'), numbers('frames', 'count', whole),
                                                      numbers('of those sent', 'percent', share)], rows)];
}

function faults({faults: counts}) {
  if (!counts) return [];
  return [table('faults', 'Faults that this load test mixed in', [texts('fault', ([kind]) => kind), numbers('frames', ([, count]) => count, whole)],
                Object.entries(counts))];
}

function clients({results_of_client: results = [], least_share_percent: least}) {
  if (results.length < 2) return [];
  const mean = results.reduce((sum, count) => sum + count, 0) / results.length;
  const ordered = results.map((count, client) => ({client, count, percent: mean > 0 ? 100 * count / mean : null}))
    .sort((a, b) => a.count - b.count || a.client - b.client);
  const columns = [numbers('client', 'client', String), numbers('results', 'count', whole), numbers('of the mean', 'percent', share)];
  const few = results.length <= 2 * SHOWN;
  const tables = few ? [table('clients', 'Clients, the least served first', columns, ordered)]
    : [table('least-served', 'The least served clients', columns, ordered.slice(0, SHOWN)),
       table('best-served', 'The best served clients', columns, ordered.slice(-SHOWN).reverse()), figuresOf('clients', 'All clients', columns, ordered)];
  return [chart('clients', 'Results of each client, the least served first', {
    x: {label: 'clients', name: 'rank', format: String, axis: WHOLE}, y: {label: 'results', format: String},
    data: [ordered.map((_, i) => i + 1), ordered.map(({count}) => count)], lines: [line('results', 'results', whole, {hasPoints: true})],
    note: `The least served client got ${fixed(0, '%')(least)} of the mean.`, figures: element('div', {}, ...tables)})];
}

function servers({results_of_server: results = {}}) {
  const rows = Object.entries(results).map(([server, count]) => ({server, count})).sort((a, b) => a.count - b.count);
  if (rows.length < 2) return [];
  return [table('servers', 'Servers, the least used first', [texts('server', 'server'), numbers('results', 'count', whole)], rows)];
}

export const outcomeSections = (run) => [element('h2', {}, 'Outcomes'), ...errors(run), ...faults(run), ...clients(run), ...servers(run)];
