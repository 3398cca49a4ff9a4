// SPDX-License-Identifier: Apache-2.0
// One cloud with its segments on the screen.
import * as THREE from 'three';
import {DepthShading} from './depth_shading.js';
import {lineSegments} from './line_shapes.js';
import {colorTable, pointMaterial} from './point_material.js';

/** A click chooses the nearest point within so many pixels. */
const REACH = 4;

/** No point is smaller. */
const LEAST_PIXELS = 1.5;

export class Pane {
  /** `cloud` has the points (main.js), `side` the segments (side.js). */
  constructor(cloud, side) {
    this.cloud = cloud;
    this.side = side;
    this.colors = colorTable(side.tree.leaves + 1);
    this.verdicts = colorTable(side.tree.leaves + 1);
    this.truthColors = colorTable(Math.max(1, cloud.truthLabels.length));
    this.material = pointMaterial({...this, cloud});
    this.points = new THREE.Points(this.#geometry(), this.material);
    this.points.frustumCulled = false;
    this.boxes = lineSegments({opacity: 0.75});
    this.chosenBox = lineSegments({opacity: 1, isOnTop: true});
    this.edges = lineSegments({opacity: 0.85, isOnTop: true});
    this.pointScene = new THREE.Scene();
    this.pointScene.add(this.points);
    this.lineScene = new THREE.Scene();
    this.lineScene.add(this.edges, this.boxes, this.chosenBox);
    this.shading = new DepthShading();
    this.target = new THREE.WebGLRenderTarget(1, 1);
    this.ids = undefined;
  }

  #geometry() {
    const {positions, rgb, truth} = this.cloud;
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute('position', new THREE.BufferAttribute(positions, 3));
    geometry.setAttribute('supervoxel', new THREE.BufferAttribute(this.side.supervoxel, 1));
    if (rgb) geometry.setAttribute('rgb', new THREE.BufferAttribute(rgb, 3, true));
    if (truth) {
      const attribute = new THREE.BufferAttribute(truth, 1);
      attribute.gpuType = THREE.IntType;  // Otherwise it would become a float.
      geometry.setAttribute('truth', attribute);
    }
    return geometry;
  }

  /** Frees what the graphics card holds of it. */
  dispose() {
    this.points.geometry.dispose();
    this.material.dispose();
    for (const table of [this.colors, this.verdicts, this.truthColors]) table.dispose();
    this.target.dispose();
  }

  /** The part of the canvas that it fills: x, y, width, height from the upper left, CSS pixels. */
  place(rectangle) { this.rectangle = rectangle; }

  /** Sets what depends on the camera, and the points to draw, as shares of all. */
  #prepare(camera, height, {begin, end}) {
    const {uniforms} = this.material, {points} = this.cloud;
    uniforms.pixelsPerUnit.value = height / (2 * Math.tan((camera.fov * Math.PI) / 360));
    const first = Math.floor(begin * points);
    this.points.geometry.setDrawRange(first, Math.ceil(end * points) - first);
  }

  /**
   * Draws a part of the points into the picture. The first part begins it, the last one adds the lines. A preview is
   * one part.
   */
  drawPart(renderer, camera, {begin, end, ratio, isPreview}) {
    const {width, height} = this.rectangle;
    if (begin === 0) this.shading.begin(renderer, width * ratio, height * ratio);
    this.#prepare(camera, height * ratio, {begin, end});
    // In a preview, fewer points are larger ones.
    this.material.uniforms.leastPixels.value = LEAST_PIXELS * (isPreview ? Math.min(2.5, 1 / Math.sqrt(end)) : 1);
    this.shading.draw(renderer, this.pointScene, camera);
    if (end >= 1 || isPreview) this.shading.draw(renderer, this.lineScene, camera);
  }

  /** Brings the picture to the viewport of the renderer. */
  show(renderer, camera, hasShading) { this.shading.show(renderer, camera, hasShading); }

  /** Finds out which point each pixel shows, by another part of the points; `ids` is set when all were drawn. */
  drawIds(renderer, camera, part) {
    const {width, height} = this.rectangle, background = renderer.getClearColor(new THREE.Color());
    if (this.idsDrawn === 0) this.target.setSize(width, height);
    renderer.setRenderTarget(this.target);
    if (this.idsDrawn === 0) {
      renderer.setClearColor(0, 0);
      renderer.clear();
      renderer.setClearColor(background, 1);
    }
    const end = Math.min(1, this.idsDrawn + part);
    this.#prepare(camera, height, {begin: this.idsDrawn, end});
    this.material.uniforms.writesIds.value = true;
    renderer.render(this.pointScene, camera);
    this.material.uniforms.writesIds.value = false;
    this.idsDrawn = end;
    if (end >= 1) this.#readIds(renderer);
    renderer.setRenderTarget(null);
  }

  #readIds(renderer) {
    const {width, height} = this.rectangle;
    const bytes = new Uint8Array(4 * width * height);
    renderer.readRenderTargetPixels(this.target, 0, 0, width, height, bytes);
    this.ids = new Uint32Array(bytes.buffer);
  }

  /** For each pixel 1 + the index of the point that it shows, or 0; undefined if that is not known. */
  get ids() { return this.#ids; }
  set ids(ids) {
    this.#ids = ids;
    this.idsDrawn = 0;
  }
  #ids;

  /** The point that is seen nearest to a position in the pane. */
  pointAt(x, y) {
    const {width, height} = this.rectangle;
    let nearest = REACH * REACH + 1, point;
    for (let dy = -REACH; dy <= REACH; ++dy) {
      for (let dx = -REACH; dx <= REACH; ++dx) {
        const column = Math.floor(x) + dx, row = height - 1 - Math.floor(y) + dy;
        if (column < 0 || column >= width || row < 0 || row >= height || dx * dx + dy * dy >= nearest) continue;
        const id = this.ids[row * width + column];
        if (id > 0) [nearest, point] = [dx * dx + dy * dy, id - 1];
      }
    }
    return point;
  }
}
