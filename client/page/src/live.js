// SPDX-License-Identifier: Apache-2.0
// The page of `segctl stream --html-live`: shows the newest frame again and again.
import {byId, setPressed} from './dom.js';

const RETRY_MS = 1000;

const wait = (ms) => new Promise((resolve) => { setTimeout(resolve, ms); });
const shown = (value) => (value === null ? '–' : value.toFixed(1));

/** The figures of a stream in a line. */
export function figures({results, rate, p50_ms: p50, p95_ms: p95, dropped, failed, late}) {
  const counts = [`${results} results`, `${rate.toFixed(1)} a second`, `p50 ${shown(p50)} ms`, `p95 ${shown(p95)} ms`,
                  `${dropped} dropped`];
  if (failed > 0) counts.push(`${failed} failed`);
  if (late > 0) counts.push(`${late} sent late`);
  return counts.join(' · ');
}

/** Follows the stream. `show` gets what load() reads, and may take its time: frames that come meanwhile are skipped. */
export async function startLive(show) {
  byId('live').hidden = false;
  const say = (text, isError = false) => {
    byId('live-message').textContent = text;
    byId('live-message').dataset.failed = String(isError);
  };
  let isPaused = false;
  byId('pause').addEventListener('click', () => {
    isPaused = !isPaused;
    setPressed(byId('pause'), isPaused);
  });
  let last = 0;
  for (;;) {
    try {
      const response = await fetch(`live?after=${last}`);
      if (!response.ok) throw new Error(`segctl answered ${response.status}.`);
      const frame = response.status === 204 ? undefined : await response.json();
      while (isPaused) await wait(100);
      if (frame === undefined) continue;
      last = frame.sequence;
      byId('live').dataset.sequence = String(last);
      if (frame.page) await show({data: frame.page, textOf: (id) => frame.arrays[id]});
      say(frame.error ?? figures(frame.stats), frame.error !== undefined);
    } catch (error) {
      say(`The stream has ended, or cannot be reached: ${error.message}`, true);
      await wait(RETRY_MS);
    }
  }
}
