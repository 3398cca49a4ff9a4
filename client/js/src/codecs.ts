// SPDX-License-Identifier: Apache-2.0
// Encodes clouds: the codecs of core/codec/README.md that need no library.
import {create} from '@bufbuild/protobuf';

import {bytesOf, concatenated} from './bytes.js';
import {checkedPoints, type CloudArrays, type Points, type Unit} from './cloud.js';
import {type Cloud, CloudSchema, LengthUnit, PcdFileSchema, PlanarCloudSchema, PointDatatype, PointFieldSchema,
        QuantisedCloudSchema, StridedCloudSchema} from './gen/segserve/v1/cloud_pb.js';
import {oneOf} from './names.js';
import {BlockList, Payload} from './payload.js';
import {checkErrorBound, quantisedBytes} from './quantised.js';
import {viewMessage, type ViewLike} from './view.js';
import {neededZstd} from './zstd.js';

/** The codecs for arrays. All but "quantised" are lossless. */
export const CODECS = ['planar', 'planar-zstd', 'strided', 'strided-zstd', 'pcd', 'quantised'] as const;
export type Codec = (typeof CODECS)[number];

/** The bytes of a PCD file, which are sent as they are. */
export interface PcdFile {
  pcd: Uint8Array;
  /** Overrides the view of the file. */
  view?: ViewLike;
  unit?: Unit;
}

const UNITS: Record<Unit, LengthUnit> = {
  m: LengthUnit.METER,
  cm: LengthUnit.CENTIMETER,
  mm: LengthUnit.MILLIMETER,
  in: LengthUnit.INCH,
  ft: LengthUnit.FOOT,
  auto: LengthUnit.AUTO,
};
const DEFAULT_ERROR_BOUND = 0.001;  // meters

/** TypeError, RangeError: the arrays do not fit, or the codec cannot encode them. Error: Zstandard is missing. */
export function encodeArrays(cloud: CloudArrays): Payload {
  const points = checkedPoints(cloud);
  const codec = checkedCodec(cloud, points);
  const header = cloudHeader(cloud.view, cloud.unit, points);
  const compresses = codec.endsWith('-zstd') || codec === 'quantised';
  const zstd = compresses ? neededZstd(`the codec '${codec}'`) : undefined;
  const blocks = new BlockList(codec.endsWith('-zstd') ? zstd : undefined);
  if (codec === 'quantised') {
    header.errorBound = checkErrorBound(cloud.errorBound ?? DEFAULT_ERROR_BOUND);
    const bytes = quantisedBytes(points, header.errorBound, neededZstd('quantised'));
    header.payload = {case: 'quantised', value: create(QuantisedCloudSchema, {data: blocks.add(bytes)})};
  } else {
    header.payload = LOSSLESS[codec](points, blocks);
  }
  return new Payload(header, blocks.bytes, points.count, points.count * (points.rgb === undefined ? 12 : 15), compresses);
}

export function encodePcdFile({pcd, view, unit}: PcdFile): Payload {
  if (!(pcd instanceof Uint8Array)) throw new TypeError('pcd: it must be a Uint8Array, the bytes of a file');
  const header = cloudHeader(view, unit);
  const blocks = new BlockList();
  header.payload = {case: 'pcdFile', value: create(PcdFileSchema, {file: blocks.add(new Uint8Array(pcd))})};
  return new Payload(header, blocks.bytes);
}

function checkedCodec({codec, view}: CloudArrays, {xyz}: Points): Codec {
  const isFar = xyz instanceof Float64Array;
  const chosen = oneOf('codec', codec ?? (view === undefined ? 'pcd' : isFar ? 'strided' : 'planar'), CODECS);
  if (view === undefined && chosen !== 'pcd') {
    throw new RangeError(`view: the codec '${chosen}' needs it: 'camera', 'world' or 'world:X,Y,Z'; ` +
                         'without a codec, the server chooses the view');
  }
  if (isFar && !chosen.startsWith('strided') && chosen !== 'pcd') {
    throw new RangeError(`codec: '${chosen}' has float coordinates, which are too coarse so far from 0; ` +
                         `'strided' and 'pcd' send doubles`);
  }
  return chosen;
}

function cloudHeader(view: ViewLike | undefined, unit: Unit | undefined, shape?: {width: number, height: number}): Cloud {
  const header = create(CloudSchema, {width: shape?.width ?? 0, height: shape?.height ?? 0});
  if (view !== undefined) header.view = viewMessage(view);
  if (unit !== undefined && unit !== 'm') header.unit = UNITS[oneOf('unit', unit, Object.keys(UNITS) as Unit[])];
  return header;
}

type Encoder = (points: Points, blocks: BlockList) => Cloud['payload'];

const LOSSLESS: Record<Exclude<Codec, 'quantised'>, Encoder> = {
  'planar': planar,
  'planar-zstd': planar,
  'strided': strided,
  'strided-zstd': strided,
  'pcd': pcdFile,
};

function planar({xyz, rgb, count}: Points, blocks: BlockList): Cloud['payload'] {
  const [x, y, z] = [0, 1, 2].map((axis) => blocks.add(bytesOf(planeOf(xyz, axis, count))));
  const value = create(PlanarCloudSchema, {x, y, z});
  if (rgb !== undefined) value.rgb = blocks.add(new Uint8Array(rgb));
  return {case: 'planar', value};
}

function planeOf(xyz: Points['xyz'], axis: number, count: number): Float32Array {
  const plane = new Float32Array(count);
  for (let i = 0, from = axis; i < count; ++i, from += 3) plane[i] = xyz[from];
  return plane;
}

/** The points as records of x, y, z and, if there are colors, 0x00RRGGBB. */
function records({xyz, rgb, count}: Points): {bytes: Uint8Array, names: string[], sizes: number[]} {
  const width = xyz.BYTES_PER_ELEMENT;
  const step = 3 * width + (rgb === undefined ? 0 : 4);
  const bytes = new Uint8Array(count * step);
  const view = new DataView(bytes.buffer);
  for (let i = 0; i < count; ++i) {
    for (let axis = 0; axis < 3; ++axis) {
      if (width === 4) view.setFloat32(i * step + 4 * axis, xyz[3 * i + axis], true);
      else view.setFloat64(i * step + 8 * axis, xyz[3 * i + axis], true);
    }
    if (rgb !== undefined) {
      view.setUint32(i * step + 3 * width, rgb[3 * i] << 16 | rgb[3 * i + 1] << 8 | rgb[3 * i + 2], true);
    }
  }
  const names = rgb === undefined ? ['x', 'y', 'z'] : ['x', 'y', 'z', 'rgb'];
  return {bytes, names, sizes: names.map((name) => (name === 'rgb' ? 4 : width))};
}

function strided(points: Points, blocks: BlockList): Cloud['payload'] {
  const {bytes, names, sizes} = records(points);
  const step = bytes.length / points.count;
  const fields = names.map((name, i) => create(PointFieldSchema, {
    name,
    offset: i * sizes[0],
    datatype: sizes[i] === 4 ? PointDatatype.FLOAT32 : PointDatatype.FLOAT64,
    count: 1,
  }));
  const value = create(StridedCloudSchema, {fields, pointStep: step, rowStep: points.width * step, data: blocks.add(bytes)});
  return {case: 'strided', value};
}

function pcdFile(points: Points, blocks: BlockList): Cloud['payload'] {
  const {bytes, names, sizes} = records(points);
  // PCL has the bits of a color in a float.
  const text = `# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS ${names.join(' ')}\nSIZE ${sizes.join(' ')}\n` +
               `TYPE ${names.map(() => 'F').join(' ')}\nCOUNT ${names.map(() => '1').join(' ')}\nWIDTH ${points.width}\n` +
               `HEIGHT ${points.height}\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS ${points.count}\nDATA binary\n`;
  const file = concatenated([new TextEncoder().encode(text), bytes]);
  return {case: 'pcdFile', value: create(PcdFileSchema, {file: blocks.add(file)})};
}
