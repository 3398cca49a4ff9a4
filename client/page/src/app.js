// SPDX-License-Identifier: Apache-2.0
// Connects the view, the controls and the state of the sides.
import {Dendrogram} from './dendrogram.js';
import {byId, element, save, setPressed, swatch, whole} from './dom.js';
import {bindKeys, showKeys} from './keys.js';
import {boxSides, setLines} from './line_shapes.js';
import {PAINTS, paintSupervoxels, paintTruth, paintVerdicts, rampColor} from './painting.js';
import * as panel from './panel.js';
import {encodePly} from './ply_file.js';
import {neighborLines} from './region_graph.js';
import {Viewer} from './viewer.js';

/** Boxes are drawn for so many of the largest segments. */
const MOST_BOXES = 400;

export class App {
  constructor({title, sides}) {
    this.title = title;
    this.sides = sides;
    this.paint = 'segments';
    this.mode = 'choose';
    this.active = 0;
    this.viewer = new Viewer(byId('view'), {onSettled: (ms) => this.#settled(ms), onPlaced: () => this.#placeHeads()});
    this.dendrogram = new Dendrogram(byId('dendrogram'), {
      chosen: (node) => this.choose(node),
      hovered: (node) => this.#hover(node === undefined ? [] : [[this.pane, node]]),
      cut: (rows) => this.setRows(rows),
    });
  }

  get side() { return this.sides[this.active]; }
  get pane() { return this.viewer.panes[this.active]; }

  start() {
    byId('panel').classList.remove('empty');
    this.#bindControls();
    this.#bindPointer();
    bindKeys(this);
    this.#showSides();
  }

  /** Shows other clouds instead. */
  replace({title, sides}) {
    [this.title, this.sides, this.hoverKey] = [title, sides, undefined];
    this.viewer.removePanes();
    this.#showSides();
  }

  /** Shows the next frame of the same scene: viewpoint, colors of segments and a cut that was chosen stay. */
  advance({title, sides}) {
    const [before] = this.sides, [next] = sides;
    if (this.hasOwnCut && before.threshold !== undefined) next.setThreshold(before.threshold);
    else if (this.hasOwnCut) next.setRows(next.tree.rowsForRegions(before.cut.segments));
    next.matchNear(before);
    [this.title, this.sides, this.hoverKey] = [title, sides, undefined];
    this.viewer.removePanes();
    this.#showSides({paint: this.paint, keepsView: true});
  }

  #showSides({paint = 'segments', keepsView = false} = {}) {
    this.#showHeads();
    for (const side of this.sides) paintTruth(this.viewer.addPane(side.cloud, side));
    // Both sides are painted alike, so that both must have labels.
    const hasTruth = this.sides.every(({truth}) => truth !== undefined);
    this.available = Object.keys(PAINTS).filter((paint) => hasTruth || (paint !== 'truth' && paint !== 'errors'));
    showKeys(this);
    panel.showPaints(this.available, (paint) => this.setPaint(paint));
    this.activate(0);
    this.setPaint(this.available.includes(paint) ? paint : 'segments');
    if (!keepsView) this.viewer.home();
    this.setPointSize(Number(byId('point-size').value));
  }

  #showHeads() {
    byId('heads').replaceChildren(...this.sides.map(() => element('div', {}, element('b'), element('span'))));
    byId('sides').hidden = this.sides.length < 2;
    byId('sides').replaceChildren(...this.sides.map((side, i) => {
      const isSameName = this.sides.every(({name}) => name === side.name);
      const text = `${'AB'[i]}: ${isSameName ? side.method : side.name}`;
      const tab = element('button', {role: 'tab', title: side.name}, text);
      tab.addEventListener('click', () => this.activate(i));
      return tab;
    }));
  }

  #placeHeads() {
    this.viewer.panes.forEach(({rectangle: {x, y, width, height}}, i) => {
      byId('heads').classList.toggle('stacked', y > 0);
      Object.assign(byId('heads').children[i].style, {left: `${x}px`, top: `${y}px`, width: `${width}px`, height: `${height}px`});
    });
  }

  #updateHeads() {
    [...byId('heads').children].forEach((head, i) => {
      const side = this.sides[i];
      head.children[0].textContent = side.name;
      const counts = [`${whole(side.cloud.points)} points`, `${whole(side.cut.segments)} segments`];
      head.children[1].textContent = [side.method, ...counts].join(' · ');
      head.classList.toggle('active', this.sides.length > 1 && i === this.active);
    });
  }

  /** Makes a side the one that the controls are for. */
  activate(i) {
    this.active = i;
    [...byId('sides').children].forEach((tab, k) => tab.setAttribute('aria-selected', String(k === i)));
    this.#updateCut();
  }

  setPaint(paint) {
    if (!this.available.includes(paint)) return;
    this.paint = paint;
    panel.markPaint(paint);
    this.#repaint();
  }

  setThreshold(threshold, isSliding) {
    this.hasOwnCut = true;
    this.side.setThreshold(threshold);
    this.#updateCut(isSliding);
  }

  setRows(rows, isSliding) {
    this.hasOwnCut = true;
    this.side.setRows(rows);
    this.#updateCut(isSliding);
  }

  /** Everything that follows from the cut. The list and the boxes, which take longer, wait for the slider to rest. */
  #updateCut(isSliding) {
    panel.showCut(this.side, isSliding);
    this.#showChosen();
    clearTimeout(this.listing);
    this.listing = setTimeout(() => {
      panel.showSegments(this.side);
      panel.markSegments(this.side);
      this.#drawBoxes();
      this.viewer.redraw();
    }, isSliding ? 80 : 0);
  }

  #repaint() {
    for (const pane of this.viewer.panes) {
      paintSupervoxels(pane, this.paint, pane.hovered);
      if (this.paint === 'errors') paintVerdicts(pane);
    }
    const rates = this.paint === 'errors' ? this.side.truth.compare(this.side.cut).rates : undefined;
    panel.showLegend(this.paint, this.side, {rates, showsGraph: this.showsGraph});
    this.#drawGraph();
    this.dendrogram.show(this.side);
    this.#updateHeads();
    this.viewer.redraw();
  }

  #showChosen() {
    const chosen = this.side.selection && this.side.describeChosen();
    panel.showChosen(this.side, chosen);
    panel.markSegments(this.side);
    const lines = this.pane.chosenBox;
    lines.visible = chosen !== undefined;
    if (chosen) setLines(lines, boxSides(chosen.box), new Array(72).fill(255));
    this.#repaint();
  }

  choose(node) {
    this.side.choose(node);
    this.#showChosen();
  }

  clear() {
    this.side.clear();
    this.#showChosen();
  }

  resize(steps) {
    this.side.resize(steps);
    this.#showChosen();
  }

  setMode(mode) {
    this.mode = mode;
    panel.markMode(mode);
  }

  /** A click on a point: it chooses a segment, or adds a prompt. */
  #click(x, y, mode) {
    const {pane, point} = this.viewer.pick(x, y);
    if (pane === undefined) return;
    const i = this.viewer.panes.indexOf(pane);
    if (i !== this.active) this.activate(i);
    if (mode === 'choose') this.side.clear();
    this.side.click(point, mode !== 'exclude');
    this.#showChosen();
  }

  #hover(hovered) {
    this.hoverKey = undefined;  // the next move of the pointer over the cloud shows its own
    for (const pane of this.viewer.panes) pane.hovered = hovered.find(([p]) => p === pane)?.[1];
    panel.markSegments(this.side, this.pane.hovered);
    for (const pane of this.viewer.panes) paintSupervoxels(pane, this.paint, pane.hovered);
    this.viewer.redraw({isMinor: true});
  }

  #hoverPoint(event) {
    const tip = byId('tip');
    if (!this.viewer.canPick || event.buttons !== 0 || event.pointerType === 'touch') return;
    const {pane, point} = this.viewer.pick(event.offsetX, event.offsetY);
    const node = pane?.side.nodeOfPoint(point);
    tip.hidden = node === undefined;
    if (node !== undefined) {
      const {side} = pane, {points} = side.tree;
      const facts = [`Segment ${side.cut.nodes.indexOf(node) + 1}`, `${whole(points[node])} points`,
                     `stability ${side.tree.stability(node).toFixed(3)}`];
      tip.replaceChildren(swatch(side.rgbOfNode(node)), facts.join(' · '));
      Object.assign(tip.style, {left: `${event.offsetX + 14}px`, top: `${event.offsetY + 14}px`});
    }
    // The same point is shown in both panes if they show the same cloud.
    const panes = this.viewer.panes.filter((other) => node !== undefined && other.cloud === pane.cloud);
    const hovered = panes.map((other) => [other, other.side.nodeOfPoint(point)]);
    const key = `${pane?.side.name} ${hovered.map(([, other]) => other)}`;
    if (key === this.hoverKey) return;
    this.#hover(hovered);
    this.hoverKey = key;
  }

  #bindPointer() {
    const canvas = byId('view');
    let down;
    canvas.addEventListener('pointerdown', (event) => { down = {x: event.clientX, y: event.clientY, at: event.timeStamp}; });
    canvas.addEventListener('pointerup', (event) => {
      if (down === undefined || Math.hypot(event.clientX - down.x, event.clientY - down.y) > 5) return;
      const mode = event.altKey || event.button === 2 ? 'exclude' : event.shiftKey ? 'include' : this.mode;
      this.#click(event.offsetX, event.offsetY, mode);
    });
    canvas.addEventListener('contextmenu', (event) => event.preventDefault());
    canvas.addEventListener('pointermove', (event) => this.#hoverPoint(event));
    canvas.addEventListener('pointerleave', () => {
      byId('tip').hidden = true;
      this.#hover([]);
    });
  }

  #bindControls() {
    const on = (id, event, action) => byId(id).addEventListener(event, action);
    on('threshold', 'input', ({target}) =>
        this.setThreshold(panel.thresholdOf(Number(target.value)), 'threshold'));
    on('regions', 'input', ({target}) =>
        this.setRows(this.side.tree.rowsAtCoarseness(Number(target.value)), 'regions'));
    on('clear', 'click', () => this.clear());
    on('larger', 'click', () => this.resize(1));
    on('smaller', 'click', () => this.resize(-1));
    on('home', 'click', () => this.viewer.home());
    on('boxes', 'click', () => this.toggleBoxes());
    on('graph', 'click', () => this.toggleGraph());
    on('shading', 'click', () => this.toggleShading());
    on('save-picture', 'click', async () => save(await this.viewer.picture(), 'segments.png'));
    on('save-ply', 'click', () => this.savePly());
    on('help', 'click', () => byId('keys').showModal());
    byId('point-size').value = 1.4;
    on('point-size', 'input', ({target}) => this.setPointSize(Number(target.value)));
    for (const button of byId('modes').children) {
      button.addEventListener('click', () => this.setMode(button.dataset.mode));
    }
    on('segments', 'click', ({target}) => this.#withRow(target, (node) => this.choose(node)));
    on('segments', 'pointerover', ({target}) => this.#withRow(target, (node) => this.#hover([[this.pane, node]])));
    on('segments', 'pointerleave', () => this.#hover([]));
  }

  #withRow(target, action) {
    const row = target.closest('li');
    if (row) action(Number(row.dataset.node));
  }

  setPointSize(scale) {
    for (const pane of this.viewer.panes) {
      pane.material.uniforms.pointScale.value = scale;
      pane.ids = undefined;
    }
    this.viewer.redraw();
  }

  toggleShading() {
    this.viewer.hasShading = !this.viewer.hasShading;
    setPressed(byId('shading'), this.viewer.hasShading);
    this.viewer.redraw();
  }

  toggleBoxes() {
    this.showsBoxes = !this.showsBoxes;
    setPressed(byId('boxes'), this.showsBoxes);
    this.#drawBoxes();
    this.viewer.redraw();
  }

  #drawBoxes() {
    for (const pane of this.viewer.panes) {
      pane.boxes.visible = Boolean(this.showsBoxes);
      if (!this.showsBoxes) continue;
      const boxes = pane.side.boxes(MOST_BOXES);
      const colors = boxes.flatMap((_, k) => Array(24).fill(pane.side.rgbOfNode(pane.side.cut.nodes[k])).flat());
      setLines(pane.boxes, boxes.flatMap(boxSides), colors);
    }
  }

  toggleGraph() {
    this.showsGraph = !this.showsGraph;
    setPressed(byId('graph'), this.showsGraph);
    this.#repaint();
  }

  #drawGraph() {
    for (const pane of this.viewer.panes) {
      pane.edges.visible = Boolean(this.showsGraph);
      pane.material.uniforms.fade.value = this.showsGraph ? 0.55 : 0;
      if (!this.showsGraph) continue;
      const {corners, colors} = neighborLines(pane.side, rampColor);
      setLines(pane.edges, corners, colors);
    }
  }

  savePly() {
    const {side} = this, {cloud} = side;
    const labelOf = (point) => (side.supervoxel[point] === 0 ? 0 : side.cut.segmentOfLeaf[side.supervoxel[point] - 1]);
    save(encodePly({...cloud, labelOf}), 'segments.ply', 'application/octet-stream');
  }

  #settled(ms) {
    byId('status').textContent = `${whole(this.viewer.points)} points in ${ms.toFixed(0)} ms`;
  }
}
