// SPDX-License-Identifier: Apache-2.0
// Colors of the nodes of a merge tree. A node has the color of its larger child, so that a segment keeps its color while
// the cut moves. The nodes of one color are a path of the tree, from a leaf up to where it joins a larger node. Paths
// whose nodes are neighbors in any cut get colors that differ as far as possible.

/** sRGB, 0 to 1 each, of Oklab (B. Ottosson, 2020), in which equal steps look equal. Unset out of gamut. */
function srgbOfOklab([lightness, a, b]) {
  const l = (lightness + 0.3963377774 * a + 0.2158037573 * b) ** 3;
  const m = (lightness - 0.1055613458 * a - 0.0638541728 * b) ** 3;
  const s = (lightness - 0.0894841775 * a - 1.291485548 * b) ** 3;
  const linear = [4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s,
                  -1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s,
                  -0.0041960863 * l - 0.7034186147 * m + 1.707614701 * s];
  if (!linear.every((v) => v >= 0 && v <= 1)) return undefined;
  return linear.map((v) => (v <= 0.0031308 ? 12.92 * v : 1.055 * v ** (1 / 2.4) - 0.055));
}

/** The most colorful color of a lightness and hue: {lab, rgb}, rgb in bytes. */
function colorful(lightness, hue) {
  for (let chroma = 0.19; ; chroma -= 0.01) {
    const lab = [lightness, chroma * Math.cos(hue), chroma * Math.sin(hue)];
    const rgb = srgbOfOklab(lab);
    if (rgb) return {lab, rgb: rgb.map((v) => Math.round(255 * v))};
  }
}

/** The color of the largest object, often the ground, is calm, and no other has it. */
const CALM = 0;

function makePalette() {
  const calm = [0.6, -0.02, -0.05];
  const colors = [{lab: calm, rgb: srgbOfOklab(calm).map((v) => Math.round(255 * v))}];
  for (const [level, lightness] of [0.72, 0.58, 0.87].entries()) {
    // Hues follow each other at 150 degrees, so that colors of near numbers look different.
    for (let hue = 0; hue < 12; ++hue) colors.push(colorful(lightness, (2 * Math.PI * (5 * hue + level / 3)) / 12));
  }
  return colors;
}

/** The colors that segments may have. All can be seen on a dark ground. */
export const PALETTE = makePalette();

/** [i * PALETTE.length + k]: how different colors i and k look. */
const DIFFERENCE = Float64Array.from(
    PALETTE.flatMap((p) => PALETTE.map((q) => Math.hypot(...p.lab.map((v, i) => v - q.lab[i])))));

/** How different two colors of the palette look; neighbors should differ by 0.1 at least. */
export function difference(i, k) { return DIFFERENCE[i * PALETTE.length + k]; }

/** The path of each node, named by its leaf. */
export function pathsOf(tree) {
  const path = new Uint32Array(tree.nodes);
  for (let node = 0; node < tree.nodes; ++node) path[node] = tree.isLeaf(node) ? node : path[tree.largerChild(node)];
  return path;
}

/** The topmost node of each path. */
function topsOf(tree, path) {
  const top = new Uint32Array(tree.leaves);
  for (let node = 0; node < tree.nodes; ++node) top[path[node]] = node;  // Parents come after their children.
  return top;
}

/** Sorted numbers without repetition. */
function unique(numbers) {
  numbers.sort();
  let count = 0;
  for (let i = 0; i < numbers.length; ++i) {
    if (i === 0 || numbers[i] !== numbers[i - 1]) numbers[count++] = numbers[i];
  }
  return numbers.subarray(0, count);
}

/**
 * Pairs of paths whose nodes are neighbors in some cut, each as two entries. `edges` has pairs of leaves that touch. A
 * pair of leaves is followed up: whichever path ends first continues in the path that it joins.
 */
function pathNeighbors(tree, edges, path, top) {
  const above = (p) => tree.parent[top[p]];
  const keys = [];
  for (let e = 0; e < edges.length; e += 2) {
    let [p, q] = [edges[e], edges[e + 1]];
    while (p !== q) {
      keys.push(p * tree.leaves + q, q * tree.leaves + p);
      if (above(p) < above(q)) p = path[above(p)]; else q = path[above(q)];
    }
  }
  return unique(Float64Array.from(keys));
}

/** Chooses a color that is far from those of `taken` neighbors, and of these one that few have. */
function chooseColor(nearest, uses) {
  const enough = Math.min(0.16, 0.85 * Math.max(...nearest.subarray(CALM + 1)));
  let best = -1;
  for (let color = CALM + 1; color < PALETTE.length; ++color) {
    if (nearest[color] >= enough && (best < 0 || uses[color] < uses[best])) best = color;
  }
  return best;
}

/** Neighbors whose colors differ less look alike. */
export const LEAST_DIFFERENCE = 0.1;

/**
 * Colors vertices one after the other. `keys` are sorted entries v * count + w of the pairs that must differ, `preferred`
 * has wishes, vertex -> color, which are granted first.
 * @return {Uint8Array} for each vertex an index into PALETTE
 */
function colorGreedily(count, keys, order, preferred) {
  const hasCalm = [...preferred.values()].includes(CALM);
  const first = new Uint32Array(count + 1);
  for (const key of keys) ++first[Math.floor(key / count) + 1];
  for (let v = 0; v < count; ++v) first[v + 1] += first[v];
  const none = 255;
  const color = new Uint8Array(count).fill(none);
  const uses = new Uint32Array(PALETTE.length);
  const nearest = new Float64Array(PALETTE.length);
  for (const v of [...preferred.keys(), ...order]) {
    if (color[v] !== none) continue;
    nearest.fill(1);
    for (let k = first[v]; k < first[v + 1]; ++k) {
      const other = color[keys[k] % count];
      if (other === none) continue;
      for (let i = 0; i < nearest.length; ++i) nearest[i] = Math.min(nearest[i], DIFFERENCE[i * nearest.length + other]);
    }
    const wish = preferred.get(v) ?? (v === order[0] && !hasCalm ? CALM : undefined);
    color[v] = wish !== undefined && nearest[wish] >= LEAST_DIFFERENCE ? wish : chooseColor(nearest, uses);
    ++uses[color[v]];
  }
  return color;
}

/**
 * The color of each node: an index into PALETTE. `edges` has pairs of leaves that touch. `preferred` has colors, node ->
 * color, that nodes get unless a neighbor looks like that.
 */
export function colorNodes(tree, edges, preferred = new Map()) {
  const path = pathsOf(tree), top = topsOf(tree, path);
  const keys = pathNeighbors(tree, edges, path, top);
  // The paths that end last are the largest objects. They choose first.
  const order = Uint32Array.from({length: tree.leaves}, (_, leaf) => leaf);
  order.sort((p, q) => tree.parent[top[q]] - tree.parent[top[p]]);
  const wishes = new Map([...preferred].map(([node, color]) => [path[node], color]));
  const ofPath = colorGreedily(tree.leaves, keys, order, wishes);
  return Uint8Array.from(path, (leaf) => ofPath[leaf]);
}

/** The color of each leaf where every leaf is a segment of its own. */
export function colorLeaves(tree, edges) {
  const keys = new Float64Array(edges.length);
  for (let e = 0; e < edges.length; e += 2) {
    keys[e] = edges[e] * tree.leaves + edges[e + 1];
    keys[e + 1] = edges[e + 1] * tree.leaves + edges[e];
  }
  return colorGreedily(tree.leaves, unique(keys), tree.order, new Map());
}
