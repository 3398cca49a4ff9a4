// SPDX-License-Identifier: Apache-2.0
// Follows the objects of a moving scene with the package of client/js.
//
//   node js_tracking.mjs PACKAGE ADDRESS FOLDER OPTIONS
//
// PACKAGE is the folder of the package. FOLDER is one that `segctl synth --moving` has made. OPTIONS is a JSON object:
//
//   by        "calls" or "stream"
//   web       whether the calls are those of the client for browsers
//   from, to  which frames are sent, by default all of them
//   pauseAt   before this frame is sent, a line on the standard input is waited for
//   rules     of the stream
//   restore   a file with the state to begin with
//   save      a file to which the last state is written
//
// Each frame has a line of JSON on the standard output.
import {once} from 'node:events';
import fs from 'node:fs';
import path from 'node:path';
import {pathToFileURL} from 'node:url';

const [folderOfPackage, address, folder, text] = process.argv.slice(2);
const {by, web = false, from = 0, to, pauseAt, rules = {}, restore, save} = JSON.parse(text);
const {Client} = await import(pathToFileURL(path.join(folderOfPackage, 'dist', web ? 'web.js' : 'index.js')));

const {frames} = JSON.parse(fs.readFileSync(path.join(folder, 'sequence.json'), 'utf8'));
const client = new Client(address);
let state = restore === undefined ? undefined : new Uint8Array(fs.readFileSync(restore));

/** The bytes of each cloud, when it was captured, and from where. */
async function* sequence() {
  for (let i = from; i < (to ?? frames.length); ++i) {
    if (i === pauseAt) await once(process.stdin, 'data');
    const {file, time, rotation, translation} = frames[i];
    const pose = [0, 1, 2].map((row) => [...rotation.slice(3 * row, 3 * row + 3), translation[row]]);
    yield {pcd: new Uint8Array(fs.readFileSync(path.join(folder, file))), time, pose};
  }
}

function say({tracks, labels}, more = {}) {
  state = tracks.state;
  console.log(JSON.stringify({ids: tracks.ids, events: tracks.events, stateBytes: tracks.state.length,
                              ofPoints: [...tracks.ofPoints(labels)], ...more}));
}

const TASKS = {
  async calls() {
    for await (const {pcd, time, pose} of sequence()) say(await client.segment({pcd, track: {state, time, pose}}));
  },

  async stream() {
    const stream = client.stream({track: {state}, ...rules});
    const stamped = async function* () {
      for await (const {pcd, time, pose} of sequence()) yield {pcd, pose, stamp: new Date(1000 * time)};
    };
    for await (const outcome of stream.map(stamped())) {
      const {address: server, attempts} = outcome.report;
      say(outcome.get(), {server, attempts});
    }
  },
};

await TASKS[by]();
if (save !== undefined) fs.writeFileSync(save, state);
await client.close?.();
process.stdin.destroy();
