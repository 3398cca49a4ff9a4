// SPDX-License-Identifier: Apache-2.0
// The result of one cloud.
import {Method} from './gen/segserve/v1/options_pb.js';
import {type ResultSummary, type Timings} from './gen/segserve/v1/result_pb.js';
import {type Vector3} from './gen/segserve/v1/segment_pb.js';
import {methodName} from './options.js';
import {checkedSteps, findPoint, type Place, type PromptedPoint} from './places.js';
import {type Candidate, leavesBelow, Selection} from './selection.js';
import {type Tracks} from './tracks.js';
import {type Cut, type MergeTree} from './tree.js';
import {type View, viewOf} from './view.js';

/** A position or direction in the frame of the cloud. */
export type Triple = readonly [number, number, number];

/** A box that holds every point of a segment, meters. */
export interface OrientedBox {
  readonly center: Triple;
  /** Right-handed unit vectors. */
  readonly axes: readonly [Triple, Triple, Triple];
  readonly halfExtents: Triple;
}

/** The statistics of a segment, meters. */
export interface Segment {
  readonly label: number;
  readonly points: number;
  readonly centroid: Triple;
  readonly box: OrientedBox;
  /** Mean of R, G and B, 0 to 255. Undefined if the cloud has no color. */
  readonly color?: Triple;
  /** Undefined if the segment is closed all around, or has too few voxels. */
  readonly normal?: Triple;
  /** The thresholds from the first to the second, at which the merge tree has the segment. Undefined by older servers. */
  readonly thresholds?: readonly [number, number];
  /** The length of that range, 0 to 1: the longer, the more certain the segment is. */
  readonly stability?: number;
}

/** How large voxels and supervoxels were, and why. For a camera and a sweep, lengths are those at 1 m distance. */
export interface Resolution {
  readonly voxel: number;  // meters
  readonly seed: number;   // meters
  /** "given", "dense", "spacing", "noise", "extent" or "sweep". */
  readonly reason: string;
  /** The depth from which the noise of the sensor exceeds a voxel, meters. Undefined if no noise is known. */
  readonly noiseDepth?: number;
}

/** Something that the owner of a cloud should know although it was segmented. */
export interface ResultWarning {
  /** For programs, such as "TOO_SPARSE". */
  readonly reason: string;
  readonly message: string;
}

/** The plane that was removed: the points p with normal . p = offset. */
export interface SupportPlane {
  /** 0 if no plane was large enough. */
  readonly points: number;
  readonly normal: Triple;
  readonly offset: number;
}

/** From the coordinates of the payload to those that were segmented: scale * (payload - offset). */
export interface Placement {
  readonly scale: Triple;
  readonly offset: Triple;
}

/** What places on an object, and places beside it, select. */
export interface Picked {
  /** For every point of the cloud, 1 if it is selected, else 0. Undefined if labels were not asked for. */
  readonly labels?: Uint32Array;
  /** The points that the places stand for. */
  readonly include: readonly PromptedPoint[];
  readonly exclude: readonly PromptedPoint[];
  /** All choices of nodes of the merge tree, from small to large. */
  readonly candidates: readonly Candidate[];
  /** The index of the one that was taken. */
  readonly candidate: number;
  /** The thresholds from the first to the second, between which a cut makes this choice. */
  readonly thresholds: readonly [number, number];
  /** The statistics of the selected points, without a normal. Set by servers, if `segments` were asked for. */
  readonly segment?: Segment;
}

/** What to select. */
export interface Places {
  /** Places on the object: pixels, positions, or indices of points. */
  readonly include: readonly (Place | number)[];
  /** Places that are not on it. */
  readonly exclude?: readonly (Place | number)[];
  /** The cut whose choice is taken; by default that of the result. */
  readonly cut?: Cut;
  /** Takes the choice that is larger by so many steps; below 0 it is smaller. */
  readonly larger?: number;
  /** The cloud that was segmented, which positions need. */
  readonly xyz?: Float32Array | Float64Array;
}

/** The wall time of each stage on the server, milliseconds. "total" holds all of them. */
export type StageTimings = Readonly<Record<string, number>>;

/** The arrays of a result, of which those are undefined that were not asked for. */
export interface ResultArrays {
  readonly labels?: Uint32Array;
  readonly supervoxels?: Uint32Array;
  readonly tree?: MergeTree;
  readonly segments?: readonly Segment[];
  readonly selection?: Picked;
  readonly tracks?: Tracks;
}

/** The columns and rows of an organized cloud, as far as the client knows them. */
export interface Shape {
  readonly width?: number;
  readonly height?: number;
}

/** What the request said of a frame, which comes back with its result. */
export interface Echo {
  readonly requestId?: string;
  readonly frameId?: string;
  readonly stamp?: Date;
}

/** @internal */
export const ECHO_NAMES: Record<keyof Echo, true> = {requestId: true, frameId: true, stamp: true};

/** What the server found in one cloud. */
export class Result implements ResultArrays, Echo {
  /** The segment of every point, in input order, from 1 by descending size. 0: not segmented. */
  readonly labels?: Uint32Array;
  /** The supervoxel of every point, from 1; 0: not segmented. */
  readonly supervoxels?: Uint32Array;
  readonly tree?: MergeTree;
  /** Of each segment, the largest first; the largest 10,000 at most. */
  readonly segments?: readonly Segment[];
  /** What the prompts of the request select. */
  readonly selection?: Picked;
  /** The ids of the objects, if the request asked to follow them. Then segments need not be a cut at one threshold. */
  readonly tracks?: Tracks;
  readonly requestId: string;
  readonly frameId: string;
  readonly stamp?: Date;

  /** The columns and rows of the cloud; undefined if only the server knows them. */
  readonly width?: number;
  readonly height?: number;
  /** Points of the cloud, finite or not. */
  readonly points: number;
  readonly finitePoints: number;
  /** The points with a segment. */
  readonly segmentedPoints: number;
  readonly voxels: number;
  readonly supervoxelCount: number;
  readonly segmentCount: number;
  readonly method: string;
  /** The threshold of the cut; undefined if the caller asked for a number of regions. */
  readonly threshold?: number;
  /** The number of regions that was asked for. */
  readonly regions?: number;
  /** The weight of color against geometry that was used, 0 to 1. */
  readonly lambda: number;
  /** The view that was used, and by which rule it was chosen, for people. */
  readonly view: View;
  readonly viewRule: string;
  readonly resolution: Resolution;
  readonly timingsMs: StageTimings;
  /** Which parts of the cloud were not used, and what is probably wrong. */
  readonly warnings: readonly ResultWarning[];
  readonly supportPlane?: SupportPlane;
  /** Set if the cloud was moved, scaled or turned before it was segmented. */
  readonly placement?: Placement;
  readonly serverVersion: string;
  /** Equal clouds with equal hashes have equal labels on every replica of one version. */
  readonly optionsHash: string;

  /** @internal */
  constructor(summary: ResultSummary, arrays: ResultArrays, shape: Shape, echo: Echo) {
    this.labels = arrays.labels;
    this.supervoxels = arrays.supervoxels;
    this.tree = arrays.tree;
    this.segments = arrays.segments;
    this.selection = arrays.selection;
    this.tracks = arrays.tracks;
    this.width = shape.width;
    this.height = shape.height;
    this.requestId = echo.requestId ?? '';
    this.frameId = echo.frameId ?? '';
    this.stamp = echo.stamp;
    this.points = Number(summary.points);
    this.finitePoints = Number(summary.finitePoints);
    this.segmentedPoints = Number(summary.segmentedPoints);
    this.voxels = Number(summary.voxels);
    this.supervoxelCount = summary.supervoxels;
    this.segmentCount = summary.segments;
    this.method = methodName(summary.method ?? Method.UNSPECIFIED);
    this.threshold = summary.threshold;
    this.regions = summary.regions;
    this.lambda = summary.lambda;
    this.view = viewOf(summary.view);
    this.viewRule = summary.viewRule;
    this.resolution = resolutionOf(summary);
    this.timingsMs = timingsOf(summary.timings);
    this.warnings = summary.warnings.map(({reason, message}) => ({reason, message}));
    this.supportPlane = supportPlaneOf(summary);
    const {placement} = summary;
    this.placement = placement && {scale: triple(placement.scale), offset: triple(placement.offset)};
    this.serverVersion = summary.serverVersion;
    this.optionsHash = summary.optionsHash;
  }

  /**
   * The segment of every point in another cut of the tree, without asking the server.
   *
   * RangeError unless exactly one of threshold and regions is given. Error unless the result has supervoxels and tree.
   */
  cut(cut: Cut): Uint32Array {
    const {tree, supervoxels} = this.#complete('cut');
    return ofPoints(supervoxels, tree.cut(cut));
  }

  /**
   * Selects an object by places on it and beside it, as `segctl pick` and the prompts of a request do: the fewest nodes of
   * the merge tree that hold all included places and no excluded one.
   *
   * RangeError if a place stands for no segmented point, nothing is included, or a supervoxel is both included and
   * excluded. Error unless the result has supervoxels and tree.
   */
  select({include, exclude = [], cut, larger = 0, xyz}: Places): Picked {
    const {tree, supervoxels} = this.#complete('select');
    const cloud = {supervoxels, width: this.width, height: this.height, xyz};
    const [included, excluded] = [include, exclude].map((places) => places.map((place) => findPoint(place, cloud)));
    const leavesOf = (points: readonly PromptedPoint[]) => points.map(({supervoxel}) => supervoxel - 1);
    const selection = new Selection(tree, leavesOf(included), leavesOf(excluded));
    const candidates = selection.candidates();
    const asked = selection.at(cut ?? this.#ownCut()) + checkedSteps(larger);
    const candidate = Math.min(Math.max(asked, 0), candidates.length - 1);
    const labels = ofPoints(supervoxels, leavesBelow(tree, candidates[candidate].nodes));
    const thresholds = selection.thresholds(candidate);
    return {labels, include: included, exclude: excluded, candidates, candidate, thresholds};
  }

  #ownCut(): Cut {
    return this.regions === undefined ? {threshold: this.threshold ?? 0} : {regions: this.regions};
  }

  #complete(what: string): {tree: MergeTree, supervoxels: Uint32Array} {
    const {tree, supervoxels} = this;
    if (tree === undefined || supervoxels === undefined) {
      throw new Error(`${what}: the outputs 'supervoxels' and 'tree' are needed, which were not asked for`);
    }
    return {tree, supervoxels};
  }
}

/** The value of each point by that of its leaf; points without a supervoxel have 0. */
function ofPoints(supervoxels: Uint32Array, ofLeaf: Uint32Array | Uint8Array): Uint32Array {
  const values = new Uint32Array(supervoxels.length);
  for (let i = 0; i < values.length; ++i) values[i] = supervoxels[i] === 0 ? 0 : ofLeaf[supervoxels[i] - 1];
  return values;
}

/** @internal */
export function triple(vector: Pick<Vector3, 'x' | 'y' | 'z'> | undefined): Triple {
  return vector === undefined ? [0, 0, 0] : [vector.x, vector.y, vector.z];
}

function resolutionOf({resolution}: ResultSummary): Resolution {
  return {
    voxel: resolution?.voxelResolution ?? 0,
    seed: resolution?.seedResolution ?? 0,
    reason: resolution?.reason ?? '',
    noiseDepth: resolution?.noiseDepth,
  };
}

function timingsOf(timings: Timings | undefined): StageTimings {
  const stages = Object.entries(timings ?? {}).filter(([name]) => name.endsWith('Ms'));
  return Object.fromEntries(stages.map(([name, ms]) => [name.slice(0, -'Ms'.length), ms as number]));
}

function supportPlaneOf({supportPlane}: ResultSummary): SupportPlane | undefined {
  if (supportPlane === undefined) return undefined;
  const {points, normalX, normalY, normalZ, offset} = supportPlane;
  return {points: Number(points), normal: [normalX, normalY, normalZ], offset};
}
