// SPDX-License-Identifier: Apache-2.0
// Eye-dome lighting (C. Boucheny, 2009): a pixel darkens where its neighbors are nearer to the viewer. It shows the shape
// of things that have no shading of their own.
import * as THREE from 'three';

const STRENGTH = 90;

const FRAGMENT = `
uniform sampler2D picture, depth;
uniform float near, far, strength, reach;
in vec2 at;
out vec4 color;

float logDepth(vec2 where) {
  float d = texture(depth, where).x;
  return d >= 1.0 ? -1.0 : log2(near * far / (far - d * (far - near)));
}

void main() {
  color = vec4(texture(picture, at).rgb, 1.0);
  float own = logDepth(at);
  vec2 pixel = reach / vec2(textureSize(depth, 0));
  float shade = 0.0;
  for (int k = 0; k < 8; ++k) {
    float angle = 0.7853981634 * float(k);
    float other = logDepth(at + pixel * vec2(cos(angle), sin(angle)));
    if (other > -1.0 && own > -1.0) shade += max(0.0, own - other);
  }
  color.rgb *= exp(-strength * shade / 8.0);
}`;

export class DepthShading {
  constructor() {
    this.target = new THREE.WebGLRenderTarget(1, 1, {depthTexture: new THREE.DepthTexture(1, 1, THREE.FloatType)});
    this.material = new THREE.ShaderMaterial({
      glslVersion: THREE.GLSL3,
      vertexShader: 'out vec2 at; void main() { at = uv; gl_Position = vec4(position.xy, 0.0, 1.0); }',
      fragmentShader: FRAGMENT,
      depthTest: false,
      depthWrite: false,
      uniforms: {picture: {value: this.target.texture}, depth: {value: this.target.depthTexture}, near: {value: 1},
                 far: {value: 1}, strength: {value: STRENGTH}, reach: {value: 1.5}},
    });
    this.scene = new THREE.Scene();
    this.scene.add(new THREE.Mesh(new THREE.PlaneGeometry(2, 2), this.material));
    this.scene.children[0].frustumCulled = false;
    this.camera = new THREE.Camera();
  }

  /** Begins a picture of this size in pixels. */
  begin(renderer, width, height) {
    this.target.setSize(width, height);
    renderer.setRenderTarget(this.target);
    renderer.clear();
    renderer.setRenderTarget(null);
  }

  /** Draws a scene over what is in the picture. */
  draw(renderer, scene, camera) {
    renderer.setRenderTarget(this.target);
    renderer.render(scene, camera);
    renderer.setRenderTarget(null);
  }

  /** Brings the picture to the viewport of the renderer, shaded or as it is. */
  show(renderer, camera, hasShading) {
    const {uniforms} = this.material;
    [uniforms.near.value, uniforms.far.value] = [camera.near, camera.far];
    uniforms.strength.value = hasShading ? STRENGTH : 0;
    renderer.render(this.scene, this.camera);
  }
}
