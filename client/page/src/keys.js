// SPDX-License-Identifier: Apache-2.0
import {byId, element} from './dom.js';
import {PAINTS} from './painting.js';

const TURN = 0.08;

/** Keys and what they do. An action gets the app. `isThere` tells whether there is something to do, for the list. */
const KEYS = [
  {keys: ['ArrowLeft'], name: '← →', text: 'turn', action: (app) => app.viewer.turn(-TURN, 0, 1)},
  {keys: ['ArrowRight'], action: (app) => app.viewer.turn(TURN, 0, 1)},
  {keys: ['ArrowUp'], name: '↑ ↓', text: 'tilt', action: (app) => app.viewer.turn(0, -TURN, 1)},
  {keys: ['ArrowDown'], action: (app) => app.viewer.turn(0, TURN, 1)},
  {keys: ['+', '='], name: '+ −', text: 'nearer, farther', action: (app) => app.viewer.turn(0, 0, 1.15)},
  {keys: ['-'], action: (app) => app.viewer.turn(0, 0, 1 / 1.15)},
  {keys: [','], name: ', .', text: 'one segment more, one less', action: (app) => app.setRows(app.side.rows - 1)},
  {keys: ['.'], action: (app) => app.setRows(app.side.rows + 1)},
  {keys: ['['], name: '[ ]', text: 'smaller, larger choice', action: (app) => app.resize(-1)},
  {keys: [']'], action: (app) => app.resize(1)},
  {keys: ['Escape'], name: 'Esc', text: 'choose nothing', action: (app) => app.clear()},
  {keys: ['b'], name: 'B', text: 'boxes', action: (app) => app.toggleBoxes()},
  {keys: ['g'], name: 'G', text: 'region graph', action: (app) => app.toggleGraph()},
  {keys: ['l'], name: 'L', text: 'shading by depth', action: (app) => app.toggleShading()},
  {keys: ['h'], name: 'H', text: 'back to the first view', action: (app) => app.viewer.home()},
  {keys: ['x'], name: 'X', text: 'the other side', isThere: (app) => app.sides.length > 1, action: (app) => app.activate((app.active + 1) % app.sides.length)},
  {keys: ['?'], name: '?', text: 'this list', action: () => byId('keys').showModal()},
  ...Object.entries(PAINTS).map(([paint, {key, title}]) =>
      ({keys: [key], name: key, text: title, isThere: (app) => app.available.includes(paint),
        action: (app) => app.setPaint(paint)})),
];

const GESTURES = [
  ['Drag', 'turn the cloud; with the right button, or two fingers, move it'],
  ['Wheel, pinch', 'nearer or farther; in the merge tree, zoom'],
  ['Click', 'choose a segment, or a branch of the merge tree'],
  ['Shift + click', 'include this point, too'],
  ['Alt + click', 'exclude this point'],
];

export function bindKeys(app) {
  document.addEventListener('keydown', (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || byId('keys').open) return;
    if (event.target.matches?.('input:not([type="range"])')) return;  // Somebody writes a text.
    const isSlider = event.target.matches?.('input');
    const entry = KEYS.find(({keys}) => keys.includes(event.key) || keys.includes(event.key.toLowerCase()));
    if (entry === undefined || (isSlider && event.key.startsWith('Arrow'))) return;
    event.preventDefault();
    entry.action(app);
  });
}

/** Lists the keys that do something for what is shown. */
export function showKeys(app) {
  const listed = KEYS.filter(({name, isThere}) => name && (isThere === undefined || isThere(app)));
  const rows = [...GESTURES, ...listed.map(({name, text}) => [name, text])];
  byId('key-list').replaceChildren(
      ...rows.flatMap(([name, text]) => [element('dt', {}, element('kbd', {}, name)), element('dd', {}, text)]));
}
