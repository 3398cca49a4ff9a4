// SPDX-License-Identifier: Apache-2.0
import {App} from './app.js';
import {byId} from './dom.js';
import {startLive} from './live.js';
import {load} from './loading.js';
import {startUploads} from './upload.js';

let app;

/** Shows what load() reads: other clouds, or the next frame of the same scene. */
async function show({data, textOf}, isNextFrame = false) {
  if (!isNextFrame) byId('status').textContent = 'Reading the points …';
  const page = await load(data, textOf);
  document.title = page.title;
  if (app) return isNextFrame ? app.advance(page) : app.replace(page);
  app = new App(page);
  app.start();
}

async function start() {
  if (byId('live-stream') !== null) return startLive((frame) => show(frame, app !== undefined));
  const data = byId('page-data');
  if (data === null) return startUploads(show);
  await show({data: JSON.parse(data.textContent), textOf: (id) => byId(id).textContent});
  for (const script of document.querySelectorAll('script[type^="application/"]')) script.remove();
}

start().catch((error) => {
  byId('status').textContent = `This page cannot be shown: ${error.message}`;
  byId('status').dataset.failed = 'true';
});
