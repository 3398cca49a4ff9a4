// SPDX-License-Identifier: Apache-2.0
import {byId, save} from '../src/dom.js';
import {drawCharts} from './chart.js';
import {overview} from './overview.js';
import {latencySections} from './latency.js';
import {throughputSections} from './throughput.js';
import {splitSection} from './split_section.js';
import {outcomeSections} from './outcomes.js';
import {setupSections} from './setup.js';

function start() {
  const json = byId('page-data').textContent;
  const run = JSON.parse(json);
  const title = `Load test of ${run.server}`;
  document.title = `${title} - segctl bench`;
  byId('title').textContent = title;
  byId('subtitle').textContent = [run.started?.replace('T', ' ').replace('Z', ' UTC'), run.host?.name && `from ${run.host.name}`,
                                  run.client_build?.version && `by segctl ${run.client_build.version}`].filter(Boolean).join(', ');
  const report = byId('report');
  report.append(...overview(run), ...latencySections(run), ...throughputSections(run), ...splitSection(run), ...outcomeSections(run),
                ...setupSections(run));
  drawCharts(report);
  byId('save-json').addEventListener('click', () => save(`${json}\n`, 'bench.json', 'application/json'));
  byId('print').addEventListener('click', () => print());
  byId('status').dataset.settled = 'true';
}

try {
  start();
} catch (error) {
  byId('status').textContent = `This page cannot be shown: ${error.message}`;
  byId('status').dataset.failed = 'true';
  throw error;
}
