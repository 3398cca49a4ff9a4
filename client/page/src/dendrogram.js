// SPDX-License-Identifier: Apache-2.0
// The merge tree as a drawing: supervoxels from top to bottom, fine cuts at the left and coarse ones at the right, and the
// cut as a line that can be moved. The numbers at the top are numbers of regions.

const MARGIN = 12, TOP = 20;

export class Dendrogram {
  /** `handlers` has chosen(node), hovered(node or undefined), cut(rows). */
  constructor(canvas, handlers) {
    this.canvas = canvas;
    this.handlers = handlers;
    this.pointers = new Map();
    canvas.addEventListener('pointerdown', (event) => this.#down(event));
    canvas.addEventListener('pointermove', (event) => this.#move(event));
    canvas.addEventListener('pointerup', (event) => this.#up(event));
    canvas.addEventListener('pointercancel', (event) => this.pointers.delete(event.pointerId));
    canvas.addEventListener('pointerleave', () => handlers.hovered(undefined));
    canvas.addEventListener('wheel', (event) => this.#wheel(event), {passive: false});
    canvas.addEventListener('dblclick', (event) => handlers.cut(this.#rows(event.offsetX)));
    new ResizeObserver(() => this.draw()).observe(canvas);
  }

  show(side) {
    if (this.side !== side) {
      this.side = side;
      [this.first, this.last] = [0, side.tree.leaves];
    }
    this.draw();
  }

  #x(rows) { return MARGIN + this.side.tree.coarseness(rows) * (this.canvas.clientWidth - 2 * MARGIN); }
  #rows(x) {
    return this.side.tree.rowsAtCoarseness((x - MARGIN) / (this.canvas.clientWidth - 2 * MARGIN));
  }
  get #cutX() { return Math.min(this.#x(this.side.rows + 0.5), this.canvas.clientWidth - 2); }
  get #height() { return this.canvas.clientHeight - TOP; }
  #y(leaf) { return TOP + (leaf - this.first) / (this.last - this.first) * this.#height; }
  #leaf(y) { return this.first + (y - TOP) / this.#height * (this.last - this.first); }
  #nodeX(node) {
    const {tree} = this.side;
    return tree.isLeaf(node) ? MARGIN : this.#x(node - tree.leaves + 1);
  }

  draw() {
    const {canvas, side} = this;
    if (side === undefined || canvas.clientWidth === 0) return;
    const ratio = Math.min(2, devicePixelRatio);
    [canvas.width, canvas.height] = [canvas.clientWidth * ratio, canvas.clientHeight * ratio];
    const pen = canvas.getContext('2d');
    pen.scale(ratio, ratio);
    this.#drawGrid(pen);
    pen.save();
    pen.beginPath();
    pen.rect(0, TOP, canvas.clientWidth, canvas.clientHeight);
    pen.clip();
    if (side.tree.leaves > 0) this.#drawTree(pen);
    pen.restore();
    this.#drawCut(pen);
  }

  #drawGrid(pen) {
    pen.fillStyle = '#6f7683';
    pen.strokeStyle = '#262a32';
    pen.font = '10px system-ui, sans-serif';
    pen.textAlign = 'center';
    let last = Infinity;
    for (const regions of [1, 2, 5, 10, 20, 50, 100, 500, 2000, 10_000, 50_000]) {
      if (regions > this.side.tree.leaves) break;
      const x = this.#x(this.side.tree.leaves - regions);
      pen.beginPath();
      pen.moveTo(x, TOP - 4);
      pen.lineTo(x, this.canvas.clientHeight);
      pen.stroke();
      if (last - x > 26) {
        pen.fillText(String(regions), x, 10);
        last = x;
      }
    }
  }

  /** Draws from the root down, and what is less than a pixel high as one bar. */
  #drawTree(pen) {
    const {tree, chosenNodes, rows} = this.side;
    const chosen = new Set(chosenNodes);
    const stack = [{node: tree.nodes - 1, x: this.canvas.clientWidth, color: undefined}];
    while (stack.length > 0) {
      let {node, x, color} = stack.pop();
      const top = this.#y(tree.begin[node]), bottom = this.#y(tree.end[node]);
      if (bottom < TOP || top > this.canvas.clientHeight) continue;
      if (color === undefined && node < tree.leaves + rows) color = `rgb(${this.side.rgbOfNode(node)})`;
      const isChosen = chosen.has(node);
      const own = this.#nodeX(node), middle = this.#middle(node);
      if (tree.isJoined(node)) pen.setLineDash([2, 3]);
      const isHovered = node === this.hoveredNode;
      const style = isChosen ? '#ffffff' : color ?? (isHovered ? '#cfd4dd' : '#5a606c');
      this.#line(pen, own, middle, x, middle, style, isChosen || isHovered ? 3 : 1.2);
      if (tree.isLeaf(node)) continue;
      if (bottom - top < 1.5) {
        pen.fillStyle = style;
        pen.fillRect(MARGIN, top, Math.max(1, own - MARGIN), Math.max(0.7, bottom - top));
        continue;
      }
      const row = node - tree.leaves;
      const children = [tree.left[row], tree.right[row]];
      const [a, b] = children.map((child) => this.#middle(child));
      this.#line(pen, own, a, own, b, style, isChosen ? 2 : 1.2);
      pen.setLineDash([]);
      for (const child of children) stack.push({node: child, x: own, color});
    }
  }

  #middle(node) { return this.#y((this.side.tree.begin[node] + this.side.tree.end[node]) / 2); }

  #line(pen, x0, y0, x1, y1, style, width) {
    pen.strokeStyle = style;
    pen.lineWidth = width;
    pen.beginPath();
    pen.moveTo(x0, y0);
    pen.lineTo(x1, y1);
    pen.stroke();
  }

  #drawCut(pen) {
    const x = this.#cutX;
    pen.setLineDash([5, 4]);
    this.#line(pen, x, TOP, x, this.canvas.clientHeight, '#7cc4ff', 1.5);
    pen.setLineDash([]);
    pen.fillStyle = '#7cc4ff';
    pen.beginPath();
    pen.moveTo(x - 6, TOP - 6);
    pen.lineTo(x + 6, TOP - 6);
    pen.lineTo(x, TOP + 2);
    pen.fill();
  }

  /** The node whose branch is drawn at a position. */
  #nodeAt(x, y) {
    const {tree} = this.side;
    const leaf = this.#leaf(y);
    if (!(leaf >= 0 && leaf < tree.leaves)) return undefined;
    let node = tree.nodes - 1;
    while (!tree.isLeaf(node) && this.#nodeX(node) > x) {
      const row = node - tree.leaves;
      node = leaf < tree.end[tree.left[row]] && leaf >= tree.begin[tree.left[row]] ? tree.left[row] : tree.right[row];
    }
    return node;
  }

  #down(event) {
    this.canvas.setPointerCapture(event.pointerId);
    this.pointers.set(event.pointerId, {x: event.offsetX, y: event.offsetY});
    this.hasMoved = false;
    this.isCutting = this.pointers.size === 1 && Math.abs(event.offsetX - this.#cutX) < 9;
  }

  #move(event) {
    const last = this.pointers.get(event.pointerId);
    if (last === undefined) return this.#hover(event);
    const before = this.#spread();
    const [dx, dy] = [event.offsetX - last.x, event.offsetY - last.y];
    if (!this.hasMoved && Math.hypot(dx, dy) < 3) return;
    this.hasMoved = true;
    this.pointers.set(event.pointerId, {x: event.offsetX, y: event.offsetY});
    if (this.isCutting) this.handlers.cut(this.#rows(event.offsetX));
    else if (this.pointers.size === 2) this.#zoom(this.#spread().size / before.size, before.middle);
    else this.#pan(-dy);
  }

  /** The middle and the distance of the pointers. */
  #spread() {
    const ys = [...this.pointers.values()].map(({y}) => y);
    return {middle: (Math.min(...ys) + Math.max(...ys)) / 2, size: Math.max(10, Math.max(...ys) - Math.min(...ys))};
  }

  #up(event) {
    const isClick = this.pointers.delete(event.pointerId) && !this.hasMoved && !this.isCutting;
    const node = isClick ? this.#nodeAt(event.offsetX, event.offsetY) : undefined;
    if (node !== undefined) this.handlers.chosen(node);
  }

  #hover(event) {
    const isNearCut = Math.abs(event.offsetX - this.#cutX) < 9;
    this.canvas.style.cursor = isNearCut ? 'ew-resize' : 'pointer';
    const node = this.#nodeAt(event.offsetX, event.offsetY);
    if (node === this.hoveredNode) return;
    this.hoveredNode = node;
    this.handlers.hovered(node);
  }

  #wheel(event) {
    event.preventDefault();
    this.#zoom(Math.exp(-0.002 * event.deltaY), event.offsetY);
  }

  #zoom(factor, y) {
    const at = this.#leaf(y), leaves = this.side.tree.leaves;
    const size = Math.min(leaves, Math.max(4, (this.last - this.first) / factor));
    this.first = at - (y - TOP) / this.#height * size;
    this.last = this.first + size;
    this.#pan(0);
  }

  #pan(dy) {
    const size = this.last - this.first;
    const first = this.first + dy / this.#height * size;
    this.first = Math.min(Math.max(0, first), Math.max(0, this.side.tree.leaves - size));
    this.last = this.first + size;
    this.draw();
  }
}
