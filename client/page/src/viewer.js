// SPDX-License-Identifier: Apache-2.0
// Shows one or two clouds side by side under one camera. It draws only when something changed: first a preview of as many
// points as a frame has time for, and when nothing changes any more, all points, part by part.
import * as THREE from 'three';
import {OrbitControls} from 'three/addons/controls/OrbitControls.js';
import {FrameBudget} from './frame_budget.js';
import {Pane} from './pane.js';

const BACKGROUND = 0x14161a;
const SETTLE_MS = 120;

export class Viewer {
  /**
   * `onSettled(milliseconds)` is called when all points were drawn, with the time that they took; `onPlaced()` when the
   * panes have other places.
   */
  constructor(canvas, {onSettled, onPlaced}) {
    THREE.ColorManagement.enabled = false;  // Colors are sRGB from the file to the screen.
    this.canvas = canvas;
    this.onSettled = onSettled;
    this.onPlaced = onPlaced;
    this.renderer = new THREE.WebGLRenderer({canvas, antialias: false, preserveDrawingBuffer: true,
                                             powerPreference: 'high-performance'});
    this.renderer.outputColorSpace = THREE.LinearSRGBColorSpace;
    this.renderer.setClearColor(BACKGROUND);
    this.renderer.autoClear = false;
    this.camera = new THREE.PerspectiveCamera(50, 1, 0.01, 1000);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.zoomToCursor = true;
    this.controls.addEventListener('change', () => this.#move());
    this.hasShading = true;
    this.budget = new FrameBudget();
    this.panes = [];
    new ResizeObserver(() => this.#resize()).observe(canvas.parentElement);
  }

  addPane(cloud, side) {
    this.panes.push(new Pane(cloud, side));
    this.#resize();
    return this.panes.at(-1);
  }

  removePanes() {
    for (const pane of this.panes) pane.dispose();
    this.panes = [];
  }

  /** The points of all panes. */
  get points() { return this.panes.reduce((sum, {cloud}) => sum + cloud.points, 0); }

  /** Puts the camera where the sensor is, or where a cloud without a sensor can be seen. */
  home() {
    const {center, radius, isCameraView, sensor} = this.panes[0].cloud;
    const target = new THREE.Vector3(...center);
    this.camera.up.set(0, isCameraView ? -1 : 0, isCameraView ? 0 : 1);
    const eye = new THREE.Vector3(0.9, -1.3, 1.1).normalize().multiplyScalar(2 * radius).add(target);
    if (isCameraView) eye.set(0.12 * radius, -0.3 * radius, -0.45 * radius);
    else if (sensor) eye.copy(new THREE.Vector3(...sensor).sub(target).clampLength(radius, 2.5 * radius).add(target));
    // A narrow pane needs a view from farther away.
    this.camera.position.copy(eye.sub(target).multiplyScalar(Math.max(1, 1.15 / this.camera.aspect)).add(target));
    [this.camera.near, this.camera.far] = [radius / 500, radius * 50];
    this.camera.updateProjectionMatrix();
    this.controls.target.copy(target);
    this.controls.update();
    this.#move();
  }

  /** Turns the view by angles about the vertical axis and the axis to the right, and moves nearer by a factor. */
  turn(horizontal, vertical, nearer) {
    const offset = this.camera.position.clone().sub(this.controls.target);
    const upright = new THREE.Quaternion().setFromUnitVectors(this.camera.up, new THREE.Vector3(0, 1, 0));
    const sphere = new THREE.Spherical().setFromVector3(offset.applyQuaternion(upright));
    sphere.theta += horizontal;
    sphere.phi += vertical;
    sphere.radius /= nearer;
    sphere.makeSafe();
    offset.setFromSpherical(sphere).applyQuaternion(upright.invert());
    this.camera.position.copy(this.controls.target).add(offset);
    this.controls.update();
    this.#move();
  }

  #resize() {
    const {clientWidth: width, clientHeight: height} = this.canvas.parentElement;
    if (width === 0 || height === 0) return;
    this.renderer.setPixelRatio(Math.min(2, devicePixelRatio));
    this.renderer.setSize(width, height, false);
    const isTall = height > width;
    this.panes.forEach((pane, i) => {
      const n = this.panes.length;
      const [w, h] = isTall ? [width, height / n] : [width / n, height];
      pane.place({x: isTall ? 0 : i * w, y: isTall ? i * h : 0, width: Math.floor(w), height: Math.floor(h)});
    });
    if (this.panes.length > 0) this.camera.aspect = this.panes[0].rectangle.width / this.panes[0].rectangle.height;
    this.camera.updateProjectionMatrix();
    this.onPlaced();
    this.#move();
  }

  #move() {
    this.isMoving = true;
    for (const pane of this.panes) pane.ids = undefined;
    this.redraw();
  }

  /**
   * Draws anew at the next chance. After a minor change, an old picture of all points is better than a preview of some.
   */
  redraw({isMinor = false} = {}) {
    if (isMinor && this.budget.points < this.points) [this.drawn, this.drawMs] = [0, 0]; else this.needsPreview = true;
    this.#setSettled(false);
    clearTimeout(this.settling);
    this.settling = setTimeout(() => {
      this.settling = undefined;
      this.isMoving = false;
      this.#schedule();
    }, SETTLE_MS);
    this.#schedule();
  }

  /** Whether all was drawn; the canvas tells it to tests. */
  #setSettled(isSettled) {
    this.isSettled = isSettled;
    this.canvas.dataset.settled = String(isSettled);
  }

  #schedule() {
    if (this.isBusy) return;  // The end of that work schedules the next.
    this.frame ??= requestAnimationFrame(() => {
      this.frame = undefined;
      this.#step();
    });
  }

  /** Does the next piece of work, and then waits for the graphics card. */
  #step() {
    const total = Math.max(1, this.points), part = Math.min(1, this.budget.points / total);
    if (this.needsPreview) {
      this.needsPreview = false;
      [this.drawn, this.drawMs] = [0, 0];
      this.#drawPart(0, part, true);
      this.#show();
      this.drawn = part >= 1 ? 1 : 0;
      this.#afterwards(part);
    } else if (this.settling === undefined && this.drawn < 1) {
      const end = Math.min(1, this.drawn + part);
      this.#drawPart(this.drawn, end);
      if (end >= 1) this.#show();
      this.#afterwards(end - this.drawn);
      this.drawn = end;
    } else if (this.settling === undefined && !this.isSettled) {
      this.#settle(part);
    }
  }

  /** Finds out, part by part, which point each pixel shows. */
  #settle(part) {
    const pane = this.panes.find(({ids}) => ids === undefined);
    if (pane !== undefined) {
      pane.drawIds(this.renderer, this.camera, part);
      return this.#afterwards(0);
    }
    this.#setSettled(true);
    this.onSettled(this.drawMs);
  }

  /** Goes on when the graphics card has drawn this share of the points. */
  #afterwards(share) {
    const gl = this.renderer.getContext(), start = performance.now();
    const fence = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
    gl.flush();
    this.isBusy = true;
    const poll = () => {
      const status = gl.isContextLost() ? gl.ALREADY_SIGNALED : gl.clientWaitSync(fence, 0, 0);
      if (status === gl.TIMEOUT_EXPIRED) return setTimeout(poll, 2);
      gl.deleteSync(fence);
      this.isBusy = false;
      const ms = performance.now() - start;
      if (share > 0) {
        this.budget.took(share * this.points, ms);
        this.drawMs += ms;
      }
      this.#schedule();
    };
    setTimeout(poll, 1);
  }

  /** Draws the points from one share of all to another into the pictures of the panes. */
  #drawPart(begin, end, isPreview = false) {
    const ratio = this.renderer.getPixelRatio();
    for (const pane of this.panes) pane.drawPart(this.renderer, this.camera, {begin, end, ratio, isPreview});
  }

  /** Brings the pictures of the panes to the screen. */
  #show() {
    const {renderer} = this;
    renderer.setScissorTest(false);
    renderer.clear();
    renderer.setScissorTest(true);
    for (const pane of this.panes) {
      const {x, y, width, height} = pane.rectangle;
      const bottom = this.canvas.parentElement.clientHeight - y - height;
      renderer.setScissor(x, bottom, width, height);
      renderer.setViewport(x, bottom, width, height);
      pane.show(renderer, this.camera, this.hasShading);
    }
    renderer.setScissorTest(false);
  }

  /** The pane and point at a position in the canvas, CSS pixels; the point is undefined where there is none. */
  pick(x, y) {
    const pane = this.panes.find(({rectangle: r}) => x >= r.x && x < r.x + r.width && y >= r.y && y < r.y + r.height);
    if (pane === undefined) return {};
    if (pane.ids === undefined) pane.drawIds(this.renderer, this.camera, 1);
    return {pane, point: pane.pointAt(x - pane.rectangle.x, y - pane.rectangle.y)};
  }

  /** Whether `pick` answers without drawing. */
  get canPick() { return !this.isMoving && this.panes.every(({ids}) => ids !== undefined); }

  /** The canvas as a PNG file. */
  picture() {
    this.#drawPart(0, 1);
    this.#show();
    return new Promise((resolve) => this.canvas.toBlob(resolve, 'image/png'));
  }
}
