// SPDX-License-Identifier: Apache-2.0
// Draws points in the color of their supervoxel, which stands in a small texture: a new cut changes nothing else.
import * as THREE from 'three';

/** What decides the color of a point. */
export const PaintKind = {SUPERVOXEL: 0, OWN: 1, TRUTH: 2, ERRORS: 3};

/** The alpha of a supervoxel's color. */
export const Emphasis = {DIMMED: 64, USUAL: 128, HOVERED: 192};

const VERTEX = `
in vec3 rgb;
in uint supervoxel;
#ifdef HAS_TRUTH
in uint truth;
#else
const uint truth = 0u;
#endif
uniform int paint;
uniform bool hasColor, writesIds, isCameraView;
uniform float spacing, pointScale, pixelsPerUnit, leastPixels, fade;
uniform sampler2D colors, truthColors, verdicts;
flat out vec4 tint;

vec4 entry(sampler2D table, uint index) {
  int width = textureSize(table, 0).x;
  return texelFetch(table, ivec2(int(index) % width, int(index) / width), 0);
}

vec3 errorColor() {
  vec4 verdict = entry(verdicts, supervoxel);
  uint label = uint(verdict.r * 255.0 + 0.5) + 256u * uint(verdict.g * 255.0 + 0.5);
  if (truth == 0u || supervoxel == 0u) return vec3(0.25, 0.26, 0.29);
  if (label != truth) return vec3(0.96, 0.26, 0.33);
  return verdict.b > 0.5 ? vec3(0.24, 0.58, 0.42) : vec3(0.98, 0.75, 0.24);
}

vec3 baseColor(vec4 ofSupervoxel) {
  if (paint == 1) return hasColor ? rgb : vec3(0.72);
  if (paint == 2) return entry(truthColors, truth).rgb;
  return paint == 3 ? errorColor() : ofSupervoxel.rgb;
}

void main() {
  vec4 seen = modelViewMatrix * vec4(position, 1.0);
  gl_Position = projectionMatrix * seen;
  float size = pointScale * (isCameraView ? spacing * position.z : spacing);
  gl_PointSize = clamp(size * pixelsPerUnit / -seen.z, leastPixels, 40.0);
  if (writesIds) {
    uint id = uint(gl_VertexID) + 1u;
    tint = vec4(uvec4(id, id >> 8, id >> 16, id >> 24) & 255u) / 255.0;
    return;
  }
  vec4 ofSupervoxel = entry(colors, supervoxel);
  vec3 color = baseColor(ofSupervoxel);
  if (ofSupervoxel.a < 0.3) color = mix(color, vec3(0.11, 0.12, 0.14), 0.78);
  if (ofSupervoxel.a > 0.7) color = mix(color, vec3(1.0), 0.38);
  tint = vec4(mix(color, vec3(0.08, 0.09, 0.1), fade), 1.0);
}`;

const FRAGMENT = `
flat in vec4 tint;
out vec4 color;
void main() { color = tint; }`;

/** A table of RGBA bytes as a texture with `count` entries. */
export function colorTable(count) {
  const width = Math.max(1, Math.ceil(Math.sqrt(count)));
  const texture = new THREE.DataTexture(new Uint8Array(4 * width * width), width, width);
  texture.needsUpdate = true;
  return texture;
}

export function pointMaterial({colors, truthColors, verdicts, cloud}) {
  return new THREE.ShaderMaterial({
    glslVersion: THREE.GLSL3,
    vertexShader: VERTEX,
    fragmentShader: FRAGMENT,
    blending: THREE.NoBlending,
    defines: cloud.truth ? {HAS_TRUTH: 1} : {},
    uniforms: {
      paint: {value: PaintKind.SUPERVOXEL},
      writesIds: {value: false},
      hasColor: {value: cloud.rgb !== undefined},
      isCameraView: {value: cloud.isCameraView},
      spacing: {value: cloud.spacing},
      pointScale: {value: 1.4},
      pixelsPerUnit: {value: 1},
      leastPixels: {value: 1.5},
      fade: {value: 0},
      colors: {value: colors},
      truthColors: {value: truthColors},
      verdicts: {value: verdicts},
    },
  });
}
