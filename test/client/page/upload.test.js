// SPDX-License-Identifier: Apache-2.0
import assert from 'node:assert/strict';
import {test} from 'node:test';
import {doneText, isDepthImage, requestFor} from '../../../client/page/src/upload.js';

const png = (bits, kind) => Uint8Array.from([0x89, 0x50, 0x4e, 0x47, ...Array(20).fill(0), bits, kind, 0, 0, 0]);
const file = (name, bytes) => new File([bytes], name);

test('depth images are told from others by their first bytes', () => {
  assert.ok(isDepthImage(png(16, 0)));
  assert.ok(!isDepthImage(png(8, 2)));
  assert.ok(!isDepthImage(png(16, 2)));
  for (const [text, expected] of [['P5\n640', true], ['P2 640', true], ['Pf\n', true], ['P6\n', false], ['PF\n', false]]) {
    assert.equal(isDepthImage(new TextEncoder().encode(text)), expected, text);
  }
});

test('a file of a cloud is sent as it is', async () => {
  const scene = file('scene & "x".pcd', 'bytes');
  const {query, body} = await requestFor([scene], '');
  assert.equal(body, scene);
  assert.equal(query.get('name'), 'scene & "x".pcd');
});

test('a pair of images is a form, in whichever order they come', async () => {
  const depth = file('d.png', png(16, 0)), color = file('c.png', png(8, 2));
  for (const files of [[depth, color], [color, depth]]) {
    const {query, body} = await requestFor(files, ' 525, 525,319.5,239.5 ');
    assert.deepEqual([body.get('depth').name, body.get('color').name], ['d.png', 'c.png']);
    assert.equal(query.get('intrinsics'), '525,525,319.5,239.5');
  }
});

test('what cannot be segmented is refused by a sentence', async () => {
  const color = file('c.png', png(8, 2));
  await assert.rejects(requestFor([color], ''), /None of these is a depth image/);
  await assert.rejects(requestFor([color, color, color], ''), /Drop one file/);
});

test('one file was, and two were segmented', () => {
  assert.equal(doneText([{name: 'a.pcd'}]), 'a.pcd was segmented.');
  assert.equal(doneText([{name: 'depth.png'}, {name: 'color.jpg'}]), 'depth.png and color.jpg were segmented.');
});
