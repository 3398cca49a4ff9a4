// SPDX-License-Identifier: Apache-2.0
// Streams frames to whichever of several servers is in reach, and uses the newest results.
//
//   node example_stream.js ADDRESS [FRAMES]
//
// A camera hands over frames faster than they may be segmented: old ones make way, and results that would come later than
// half a second are of no use.
import {argv} from 'node:process';
import {setTimeout as sleep} from 'node:timers/promises';

import {Client, type FrameArguments, type Outcome} from 'segserve';

const [WIDTH, HEIGHT, FOCAL_LENGTH] = [160, 120, 131.25];

/** Frames of a box on a table, 30 a second. */
async function* camera(count: number): AsyncGenerator<FrameArguments> {
  for (let number = 0; number < count; ++number) {
    const xyz = new Float32Array(3 * WIDTH * HEIGHT);
    const rgb = new Uint8Array(3 * WIDTH * HEIGHT);
    for (let pixel = 0; pixel < WIDTH * HEIGHT; ++pixel) {
      const x = (pixel % WIDTH - WIDTH / 2) / FOCAL_LENGTH;
      const y = (Math.floor(pixel / WIDTH) - HEIGHT / 2) / FOCAL_LENGTH;
      const isBox = Math.abs(x - number / 200) < 0.15 && Math.abs(y) < 0.15;
      const z = isBox ? 0.8 : 1;
      xyz.set([x * z, y * z, z], 3 * pixel);
      rgb.set(isBox ? [200, 60, 40] : [180, 180, 170], 3 * pixel);
    }
    yield {xyz, rgb, width: WIDTH, height: HEIGHT, frameId: 'camera', timeToLiveMs: 500};
    await sleep(1000 / 30);
  }
}

function describe({sequence, kind, result, error, report}: Outcome): string {
  if (result === undefined) return `frame ${sequence}: ${kind}, ${error?.message}`;
  const age = (report.outcomeDone ?? NaN) - report.handedOver;
  return `frame ${sequence}: ${result.segmentCount} segments after ${age.toFixed()} ms`;
}

const client = new Client(argv[2]);
const stream = client.stream({view: 'camera', whenBehind: 'drop_oldest', maxInFlight: 2, outputs: ['labels', 'segments']});
for await (const outcome of stream.map(camera(Number(argv[3] ?? 30)))) console.log(describe(outcome));
await client.close();
