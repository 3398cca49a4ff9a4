// SPDX-License-Identifier: Apache-2.0
// Shows the state of a side in the controls beside the view.
import {byId, element, length, setPressed, swatch, whole} from './dom.js';
import {PAINTS, rampColor} from './painting.js';

/** More segments than this are not listed. */
const MOST_LISTED = 250;

/** The ends of the slider of the threshold are 0 and 1; between, it is logistic, because methods crowd at the ends. */
const STEEPNESS = 18;
export const thresholdOf = (slider) =>
    (slider <= 0 ? 0 : slider >= 1 ? 1 : 1 / (1 + Math.exp(-STEEPNESS * (slider - 0.5))));
const sliderOf = (threshold) =>
    Math.min(1, Math.max(0, 0.5 + Math.log(threshold / Math.max(1e-300, 1 - threshold)) / STEEPNESS));

const percent = (share) => `${(100 * share).toFixed(1)} %`;
const width = (share) => `${100 * share}%`;
const number = (value) => String(Number(value.toPrecision(3)));

export function showCut(side, isSliding) {
  const {tree, cut, threshold, thresholds} = side;
  if (isSliding !== 'threshold') byId('threshold').value = sliderOf(threshold ?? thresholds.to);
  if (isSliding !== 'regions') byId('regions').value = tree.coarseness(side.rows);
  byId('threshold-value').textContent = threshold === undefined ? 'no threshold' : number(threshold);
  byId('regions-value').textContent = `${whole(cut.segments)} of ${whole(tree.leaves)}`;
}

function segmentRow(side, k) {
  const node = side.cut.nodes[k], {points} = side.tree;
  const bar = element('span', {class: 'bar', title: `stability ${number(side.tree.stability(node))}`}, element('b'));
  const {fewest, most} = side.tree.regions(node), at = (regions) => side.tree.coarseness(side.tree.leaves - regions);
  bar.firstChild.style.left = width(at(most));
  bar.firstChild.style.width = width(at(fewest) - at(most));
  const row = element('li', {'data-node': node}, swatch(side.rgbOfNode(node)), String(k + 1), bar,
                      element('em', {}, whole(points[node])));
  return row;
}

export function showSegments(side) {
  const count = Math.min(MOST_LISTED, side.cut.segments);
  byId('segments').replaceChildren(...Array.from({length: count}, (_, k) => segmentRow(side, k)));
  const rest = side.cut.segments - count;
  byId('segment-count').textContent = rest > 0 ? `(the largest ${count} of ${whole(side.cut.segments)})`
                                               : `(${side.cut.segments})`;
}

/** Marks the rows of the chosen nodes and of the hovered one. */
export function markSegments(side, hovered) {
  const chosen = new Set(side.chosenNodes);
  for (const row of byId('segments').children) {
    const node = Number(row.dataset.node);
    row.classList.toggle('chosen', chosen.has(node));
    row.classList.toggle('hovered', node === hovered);
  }
}

function facts(side, chosen) {
  const {points, centroid, color, box, thresholds, nodes} = chosen;
  const {placement, points: all} = side.cloud;
  const place = centroid.map((v, k) => v / placement.scale[k] + placement.offset[k]);
  const list = [['Points', `${whole(points)} (${percent(points / all)})`],
                ['Size', box.halfExtents.map((half) => length(2 * half)).join(' × ')],
                ['Centroid', place.map((v) => v.toFixed(3)).join(', ')]];
  if (color) list.push(['Mean color', element('span', {}, swatch(color), color.map(Math.round).join(', '))]);
  list.push(['Thresholds', thresholds.from < thresholds.to
      ? `${number(thresholds.from)} – ${number(thresholds.to)}` : 'at no threshold']);
  list.push(['Stability', number(thresholds.to - thresholds.from)]);
  if (nodes.length === 1) {
    const {fewest, most} = side.tree.regions(nodes[0]);
    list.push(['Regions', fewest <= most ? `${whole(fewest)} – ${whole(most)}` : '–']);
  }
  list.push([nodes.length === 1 ? 'Node' : 'Nodes', nodes.slice(0, 6).join(', ') + (nodes.length > 6 ? ', …' : '')]);
  return list.flatMap(([name, value]) => [element('dt', {}, name), element('dd', {}, value)]);
}

function titleOf(side, nodes) {
  if (nodes.length !== 1) return `${nodes.length} nodes`;
  const segment = side.cut.nodes.indexOf(nodes[0]);
  if (segment >= 0) return `Segment ${segment + 1}`;
  return nodes[0] < side.tree.leaves + side.rows ? 'Part of a segment' : 'Union of segments';
}

/** Shows the card of what is chosen; `chosen` is Side.describeChosen() or undefined. */
export function showChosen(side, chosen) {
  const isConflict = side.clicks.length > 0 && chosen === undefined;
  byId('chosen').hidden = chosen === undefined && !isConflict;
  if (isConflict) {
    byId('chosen-title').textContent = 'Nothing is included';
    byId('chosen-facts').replaceChildren();
    byId('chosen-hint').textContent = 'Include a point, too.';
  }
  if (chosen === undefined) return;
  byId('chosen-title').replaceChildren(titleOf(side, chosen.nodes));
  byId('chosen-facts').replaceChildren(...facts(side, chosen));
  const begin = side.tree.coarseness(chosen.firstRows), end = side.tree.coarseness(chosen.lastRows);
  byId('chosen-range').style.left = width(begin);
  byId('chosen-range').style.width = width(end - begin);
  byId('chosen-cut').style.left = width(side.tree.coarseness(side.rows));
  byId('smaller').disabled = side.size === 0;
  byId('larger').disabled = side.size === side.selection.steps.length;
  const clicks = (isPositive) => side.clicks.filter((click) => click.isPositive === isPositive).length;
  byId('chosen-hint').textContent = `Candidate ${side.size + 1} of ${chosen.candidates}` +
      (clicks(false) > 0 || clicks(true) > 1 ? `; ${clicks(true)} included, ${clicks(false)} excluded.` : '.');
}

const legendRow = (rgb, text) => element('div', {}, swatch(rgb), text);

/** Says what the colors mean. `rates` are those of GroundTruth.compare, if errors are shown. */
export function showLegend(paint, side, {rates, showsGraph}) {
  const rows = {
    segments: () => [],
    original: () => (side.cloud.rgb ? [] : ['The cloud has no colors.']),
    supervoxels: () => [`${whole(side.tree.leaves)} supervoxels, the leaves of the merge tree`],
    normals: () => [`Direction of each supervoxel: x red, y green, z blue`],
    stability: () => [heightRamp(), 'Length of the range of thresholds over which a segment exists: 0 to 1'],
    truth: () => [`${whole(Math.max(0, side.cloud.truthLabels.length - 1))} labels of the file`],
    errors: () => [legendRow([61, 148, 107], `right: ${percent(rates.right)}`),
                   legendRow([245, 66, 84], `leaked into another object's segment: ${percent(rates.leaked)}`),
                   legendRow([250, 191, 61], `split off its object: ${percent(rates.split)}`)],
  }[paint]();
  if (showsGraph) rows.push('Edges between segments: from violet to yellow by the threshold of their union', heightRamp());
  byId('legend').hidden = rows.length === 0;
  byId('legend').replaceChildren(...rows);
}

function heightRamp() {
  const ramp = element('div', {class: 'ramp'});
  const stops = [0, 0.25, 0.5, 0.75, 1].map((v) => `rgb(${rampColor(v)})`);
  ramp.style.background = `linear-gradient(90deg, ${stops.join(', ')})`;
  return ramp;
}

export function showPaints(available, choose) {
  byId('paints').replaceChildren(...available.map((paint) => {
    const button = element('button', {'data-paint': paint, role: 'radio', title: `Key ${PAINTS[paint].key}`},
                           PAINTS[paint].title);
    button.addEventListener('click', () => choose(paint));
    return button;
  }));
}

export function markPaint(paint) {
  for (const button of byId('paints').children) {
    button.setAttribute('aria-checked', String(button.dataset.paint === paint));
  }
}

export function markMode(mode) {
  for (const button of byId('modes').children) setPressed(button, button.dataset.mode === mode);
}
