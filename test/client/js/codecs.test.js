// SPDX-License-Identifier: Apache-2.0
// How clouds become bytes.
import assert from 'node:assert/strict';
import {before, describe, it} from 'node:test';
import {ours, useZstd} from './package.js';

const {encode, useZstd: use} = await ours('index');
const {concatenated} = await ours('bytes');
const {decompressed} = await ours('zstd');
const {neededZstd} = await ours('zstd');
const {Compression} = await ours('gen/segserve/v1/block_pb');

const XYZ = Float32Array.of(0, 0, 1, NaN, 0, 1, 0.002, -0.002, 1);
const RGB = Uint8Array.of(0x10, 0x20, 0x30, 0xff, 0xff, 0xff, 0x11, 0x20, 0x33);
const floats = (bytes) => new Float32Array(bytes.slice().buffer);
const hex = (bytes) => Buffer.from(bytes).toString('hex');
const textOf = (bytes) => Buffer.from(bytes).toString('latin1');

describe('planar', () => {
  it('has a plane for each coordinate', () => {
    const {blocks, header, points, size, decodedBytes} = encode({xyz: XYZ, rgb: RGB, view: 'camera'});
    assert.deepEqual(blocks.slice(0, 3).map(floats), [Float32Array.of(0, NaN, 0.002), Float32Array.of(0, 0, -0.002),
                                                      Float32Array.of(1, 1, 1)]);
    assert.deepEqual(blocks[3], RGB);
    assert.deepEqual([header.payload.case, header.width, header.height, points, size, decodedBytes], ['planar', 3, 1, 3, 45, 45]);
  });

  it('keeps what was given although the arrays change', () => {
    const xyz = XYZ.slice(), rgb = Buffer.from(RGB), pcd = Buffer.from(RGB), depth = Buffer.from(RGB), color = Buffer.from(RGB);
    const intrinsics = {fx: 1, fy: 1, cx: 0, cy: 0};
    const payloads = [encode({xyz, rgb, view: 'camera'}), encode({pcd}), encode({depth, color, intrinsics})];
    for (const array of [xyz, rgb, pcd, depth, color]) array.fill(9);
    assert.equal(payloads[0].crc32, encode({xyz: XYZ, rgb: RGB, view: 'camera'}).crc32);
    assert.deepEqual([payloads[0].blocks[3], payloads[1].blocks, payloads[2].blocks], [RGB, [RGB], [RGB, RGB]]);
  });
});

describe('strided', () => {
  it('is the layout of PointCloud2', () => {
    const {blocks, header: {payload: {value}, width, height}} =
        encode({xyz: XYZ, rgb: RGB, width: 1, height: 3, view: 'camera', codec: 'strided'});
    assert.deepEqual(value.fields.map(({name, offset}) => `${name} ${offset}`), ['x 0', 'y 4', 'z 8', 'rgb 12']);
    assert.deepEqual([value.pointStep, value.rowStep, width, height], [16, 16, 1, 3]);
    assert.equal(hex(blocks[0].subarray(12, 16)), '30201000');
  });

  it('keeps the digits of doubles that are far from 0', () => {
    const xyz = Float64Array.of(500_000.001, 5_000_000.25, 3);
    const {header: {payload}, blocks} = encode({xyz, view: 'world'});
    assert.deepEqual([payload.case, payload.value.pointStep], ['strided', 24]);
    assert.deepEqual(new Float64Array(blocks[0].slice().buffer), xyz);
    assert.match(textOf(encode({xyz}).blocks[0]), /SIZE 8 8 8\n/);
    assert.throws(() => encode({xyz, view: 'world', codec: 'planar'}), /too coarse so far from 0/);
    assert.equal(encode({xyz: Float64Array.of(1, 2, 3), view: 'world'}).header.payload.case, 'planar');
  });
});

describe('a PCD file', () => {
  it('is what is sent without a view, so that the server chooses it', () => {
    const {header, blocks} = encode({xyz: XYZ, rgb: RGB});
    assert.deepEqual([header.payload.case, header.view], ['pcdFile', undefined]);
    assert.match(textOf(blocks[0]), /FIELDS x y z rgb\nSIZE 4 4 4 4\nTYPE F F F F\nCOUNT 1 1 1 1\nWIDTH 3\nHEIGHT 1\n/);
    assert.throws(() => encode({xyz: XYZ, codec: 'strided'}), /the codec 'strided' needs it/);
  });

  it('goes as it is', () => {
    const {header, blocks, points} = encode({pcd: RGB, view: 'world:1,2,3', unit: 'mm'});
    assert.deepEqual([blocks, points, header.width], [[RGB], undefined, 0]);
    assert.deepEqual([header.view.sensor.x, header.view.sensor.z, header.unit], [1, 3, 3]);
  });
});

describe('quantised', () => {
  before(useZstd);

  it('gives the example of the format', () => {
    const [data] = encode({xyz: XYZ, rgb: RGB, view: 'camera', codec: 'quantised'}).blocks;
    assert.equal(hex(data.subarray(0, 24)), '534547510100010003000000010000000200000001010200');
    assert.equal(hex(decompressed(data.subarray(40), 15, 'data')), '0500020003e8000300100120003003');
  });

  it('keeps the bound', () => {
    const count = 2000;
    const xyz = Float32Array.from({length: 3 * count}, (_, i) => 4 * Math.sin(i * i));
    for (const errorBound of [0.0001, 0.001, 0.01]) {
      const [data] = encode({xyz, view: 'world', codec: 'quantised', errorBound}).blocks;
      const view = new DataView(data.buffer, data.byteOffset);
      const [planes, step] = [[20, 21, 22].map((at) => data[at]), view.getFloat64(24, true)];
      assert.ok(errorBound <= step && step <= 2 * errorBound);
      const total = planes.reduce((sum, each) => sum + each, 0);
      const body = decompressed(data.subarray(40), total * count, 'data');
      for (let axis = 0, begin = 0; axis < 3; begin += planes[axis++] * count) {
        for (let k = 0, cell = 0; k < count; ++k) {
          let zigzag = 0;
          for (let plane = 0; plane < planes[axis]; ++plane) zigzag += body[begin + plane * count + k] * 256 ** plane;
          cell += zigzag % 2 ? -(zigzag + 1) / 2 : zigzag / 2;
          assert.ok(Math.abs(Math.fround((cell + 0.5) * step) - xyz[3 * k + axis]) <= errorBound);
        }
      }
    }
  });

  it('refuses bounds that cannot be kept', () => {
    for (const errorBound of [0.00001, 0.1, NaN]) {
      assert.throws(() => encode({xyz: XYZ, view: 'camera', codec: 'quantised', errorBound}), /^RangeError: errorBound: /);
    }
    const far = Float32Array.of(5000, 0, 1);
    assert.throws(() => encode({xyz: far, view: 'camera', codec: 'quantised', errorBound: 0.0001}), /cannot be kept within/);
  });

  it('takes a cloud without finite points', () => {
    const [data] = encode({xyz: new Float32Array(27).fill(NaN), view: 'camera', codec: 'quantised'}).blocks;
    assert.equal(hex(data.subarray(16, 24)), '0000000000000000');
    assert.equal(hex(decompressed(data.subarray(40), 2, 'data')), '0000');
  });
});

describe('a view of several cameras', () => {
  const seen = (...cameras) => encode({xyz: XYZ, view: {kind: 'world', cameras}}).header.view;

  it('tells how many points each has, and where it stands', () => {
    const {kind, sensor, cameras} = seen({points: 2, sensor: [1, 2, 3]}, {points: 7, sensor: [-1, -2, -3]});
    assert.deepEqual([kind, sensor], [2, undefined]);
    assert.deepEqual(cameras.map(({points, sensor: {x, y, z}}) => [points, x, y, z]), [[2, 1, 2, 3], [7, -1, -2, -3]]);
    assert.deepEqual(seen().cameras, []);
  });

  it('is refused if it makes no sense', () => {
    const camera = {points: 1, sensor: [0, 0, 1]};
    assert.throws(() => seen({...camera, points: 0}), /^RangeError: view: a camera has 0 points/);
    assert.throws(() => seen({...camera, sensor: [0, NaN, 1]}), /is not a position of three finite numbers/);
    assert.throws(() => seen(...Array(65).fill(camera)), /there are 65 cameras, but at most 64/);
    assert.throws(() => encode({xyz: XYZ, view: {kind: 'camera', cameras: [camera]}}), /only a 'world' without a sensor/);
    assert.throws(() => encode({xyz: XYZ, view: {kind: 'world', sensor: [0, 0, 1], cameras: [camera]}}), /without a sensor/);
  });
});

describe('Zstandard', () => {
  before(useZstd);

  it('compresses a block if that makes it smaller', () => {
    const flat = encode({xyz: new Float32Array(3000).fill(1), view: 'camera', codec: 'planar-zstd'});
    assert.ok(flat.size < 300 && flat.compressed);
    assert.equal(flat.header.payload.value.x.compression, Compression.ZSTD);
    assert.deepEqual(new Uint8Array(decompressed(flat.blocks[0], 4000, 'x')), new Uint8Array(new Float32Array(1000).fill(1).buffer));
    const noise = Float32Array.from({length: 300}, (_, i) => Math.fround(Math.sin(i * i * i) * 100));
    assert.equal(encode({xyz: noise, view: 'camera', codec: 'planar-zstd'}).header.payload.value.x.compression, Compression.NONE);
  });

  it('refuses frames that lie', () => {
    const frame = neededZstd('x').compress(new Uint8Array(100));
    assert.equal(decompressed(frame, 100, 'x').length, 100);
    assert.throws(() => decompressed(frame, 99, 'x'), /declares 100 bytes, not the claimed 99/);
    assert.throws(() => decompressed(frame.subarray(0, 5), 100, 'x'), /no frame of Zstandard/);
    assert.throws(() => decompressed(new Uint8Array(100), 100, 'x'), /no frame of Zstandard/);
    assert.throws(() => decompressed(concatenated([frame.subarray(0, 7), new Uint8Array(3).fill(255)]), 100, 'x'), RangeError);
    const large = neededZstd('x').compress(new Uint8Array(70_000));
    assert.equal(decompressed(large, 70_000, 'x').length, 70_000);
  });

  it('is asked for by name where there is none', async () => {
    use(undefined);
    try {
      for (const codec of ['planar-zstd', 'quantised']) {
        assert.throws(() => encode({xyz: XYZ, view: 'camera', codec}), new RegExp(`the codec '${codec}' needs Zstandard`));
      }
    } finally {
      await useZstd();
    }
  });
});

describe('images', () => {
  const camera = {fx: 100, fy: 100, cx: 1, cy: 0.5};

  it('of integers are a PGM file, those of floats a PFM file with the last row first', () => {
    const depth = {width: 2, height: 2, data: Uint16Array.of(1, 256, 0, 65535)};
    const {blocks, header, points} = encode({depth, intrinsics: camera});
    assert.equal(textOf(blocks[0]), 'P5\n2 2\n65535\n\0\x01\x01\0\0\0\xff\xff');
    assert.deepEqual([header.width, header.height, points, header.payload.value.depthScale], [2, 2, 4, 0.001]);
    const meters = encode({depth: {...depth, data: Float32Array.of(1, 2, 3, 4)}, intrinsics: camera});
    assert.deepEqual(floats(meters.blocks[0].subarray(-16)), Float32Array.of(3, 4, 1, 2));
    assert.equal(meters.header.payload.value.depthScale, 1);
  });

  it('of color are gray, RGB or RGBA', () => {
    const depth = {width: 1, height: 1, data: Uint16Array.of(1)};
    const file = (...data) => textOf(encode({depth, color: {width: 1, height: 1, data: Uint8ClampedArray.of(...data)},
                                             intrinsics: camera}).blocks[1]);
    assert.deepEqual([file(65), file(65, 66, 67), file(65, 66, 67, 0)], ['P5\n1 1\n255\nA', 'P6\n1 1\n255\nABC', 'P6\n1 1\n255\nABC']);
    assert.throws(() => file(65, 66), /neither gray, RGB nor RGBA/);
  });

  it('may be files, whose size is read if it is plain to see', () => {
    const png = Buffer.concat([Buffer.from('\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\0\x05\0\0\0\x03', 'latin1'), Buffer.alloc(9)]);
    const {header, points} = encode({depth: new Uint8Array(png), color: RGB, intrinsics: camera, colorIntrinsics: camera});
    assert.deepEqual([header.width, header.height, points, header.payload.value.colorIntrinsics.fx], [5, 3, 15, 100]);
    assert.equal(encode({depth: RGB, intrinsics: camera}).points, undefined);
  });

  it('that make no sense are refused', () => {
    const depth = {width: 2, height: 1, data: Uint16Array.of(1, 2)};
    assert.throws(() => encode({depth: {...depth, width: 3}, intrinsics: camera}), /no image of 3 x 1 pixels/);
    assert.throws(() => encode({depth: {...depth, data: [1, 2]}, intrinsics: camera}), /Uint16Array or a Float32Array/);
    assert.throws(() => encode({depth, intrinsics: {...camera, fx: 0}}), /intrinsics: fx 0/);
    assert.throws(() => encode({depth, rgb: RGB, intrinsics: camera}), /'rgb' does not go with 'depth'/);
  });
});

describe('arrays', () => {
  it('that make no sense are refused before anything is sent', () => {
    for (const [wrong, why] of [
      [{xyz: [0, 0, 1]}, /xyz: it must be a Float32Array/], [{xyz: new Float32Array(0)}, /there is no point/],
      [{xyz: new Float32Array(4)}, /three for each point/], [{xyz: XYZ, rgb: new Uint8Array(8)}, /must have 9/],
      [{xyz: XYZ, rgb: new Float32Array(9)}, /rgb: it must be a Uint8Array/], [{xyz: XYZ, width: 3}, /they go together/],
      [{xyz: XYZ, width: 2, height: 2}, /2 x 2 is not the number of points, 3/], [{xyz: XYZ, codec: 'zip'}, /there is no 'zip'/],
      [{xyz: XYZ, unit: 'mile'}, /there is no 'mile'/], [{xyz: XYZ, view: 'cam'}, /neither 'camera' nor 'world'/],
      [{xyz: XYZ, view: 'world:1,2'}, /is not camera, world or world:X,Y,Z/], [{xyz: XYZ, view: 'camera:1,2,3'}, /at the origin/],
      [{xyz: XYZ, view: {kind: 'world', sensor: [1, NaN, 3]}}, /three finite numbers/], [{}, /give one of xyz, pcd, depth, payload/],
      [{xyz: XYZ, pcd: RGB}, /not xyz and pcd/], [{xyz: XYZ, colour: RGB}, /there is no 'colour'/],
    ]) {
      assert.throws(() => encode(wrong), why);
    }
  });
});
