// SPDX-License-Identifier: Apache-2.0
// How a cloud is segmented, and what the answer shall hold.
import {create, ScalarType} from '@bufbuild/protobuf';

import {Compression} from './gen/segserve/v1/block_pb.js';
import {Method, MethodSchema, type Outputs, OutputsSchema, Preset, PresetSchema, type SegmentOptions,
        SegmentOptionsSchema} from './gen/segserve/v1/options_pb.js';
import {oneOf} from './names.js';
import {hasZstd} from './zstd.js';

/** The names of numeric options, such as "voxelResolution". */
export type OptionName = Exclude<keyof SegmentOptions, 'method' | 'preset' | 'cut' | '$typeName' | '$unknown'>;
/** Options by name, which `Client.info()` describes. */
export type OptionValues = Partial<Record<OptionName, number>>;

/** How a cloud is segmented. What is left out has the server's default. The server checks ranges. */
export interface Segmentation {
  /** The name of a method, such as "border", the default. */
  method?: string;
  /** What kind of cloud it is: "auto", "tabletop", "room", "lidar" or "scan". Without it, the cloud tells. */
  preset?: string;
  /** Where the merge tree is cut, 0 to 1. */
  threshold?: number;
  /** The number of segments that the tree is cut to, instead of a threshold. */
  regions?: number;
  options?: OptionValues;
}

export const SEGMENTATION_NAMES: Record<keyof Segmentation, true> =
    {method: true, preset: true, threshold: true, regions: true, options: true};

/** The parts of a result. */
export const OUTPUTS = ['labels', 'supervoxels', 'tree', 'segments'] as const;
export type Output = (typeof OUTPUTS)[number];
/** With supervoxels and tree, any cut can be made later. */
export const DEFAULT_OUTPUTS: readonly Output[] = ['labels', 'supervoxels', 'tree'];

/** The names of the methods, as on the command line. */
export const METHODS: readonly string[] = MethodSchema.values.filter(({number}) => number !== Method.UNSPECIFIED)
                                              .map(({localName}) => commandLineName(localName));

function commandLineName(localName: string): string {
  return localName.toLowerCase().replaceAll('_', '-');
}

/** The name of a method, as the server counts it; "" if this version does not know it. */
export function methodName(number: Method): string {
  const value = MethodSchema.value[number];
  return value === undefined || number === Method.UNSPECIFIED ? '' : commandLineName(value.localName);
}

function methodNumber(name: string): Method {
  const number = MethodSchema.values.find(({localName}) => commandLineName(localName) === name)?.number;
  if (number === undefined || number === Method.UNSPECIFIED) oneOf('method', name, METHODS);
  return number as Method;
}

/** The names of the presets, as on the command line. */
export const PRESETS: readonly string[] = PresetSchema.values.filter(({number}) => number !== Preset.UNSPECIFIED)
                                              .map(({localName}) => commandLineName(localName));

function presetNumber(name: string): Preset {
  const number = PresetSchema.values.find(({localName}) => commandLineName(localName) === name)?.number;
  if (number === undefined || number === Preset.UNSPECIFIED) oneOf('preset', name, PRESETS);
  return number as Preset;
}

const NUMBERS = new Map(SegmentOptionsSchema.fields.filter((field) => field.fieldKind === 'scalar')
                            .map((field) => [field.localName, field.scalar === ScalarType.UINT32]));
const MOST_UINT32 = 2 ** 32 - 1;

/** The options of a request. RangeError: an unknown name, or two ways to cut. TypeError: a value is no number. */
export function optionsMessage({method, preset, threshold, regions, options}: Segmentation): SegmentOptions {
  const message = create(SegmentOptionsSchema);
  if (method !== undefined) message.method = methodNumber(method);
  if (preset !== undefined) message.preset = presetNumber(preset);
  if (threshold !== undefined && regions !== undefined) {
    throw new RangeError('threshold, regions: the tree can be cut in one of the two ways only');
  }
  if (threshold !== undefined) message.cut = {case: 'threshold', value: checkedNumber('threshold', threshold)};
  if (regions !== undefined) message.cut = {case: 'regions', value: checkedNumber('regions', regions)};
  for (const [name, value] of Object.entries(options ?? {})) {
    if (value !== undefined) message[optionName(name)] = checkedNumber(name, value);
  }
  return message;
}

function optionName(name: string): OptionName {
  const known = [...NUMBERS.keys()].filter((entry) => entry !== 'threshold' && entry !== 'regions');
  return oneOf('options', name, known) as OptionName;
}

function checkedNumber(name: string, value: number): number {
  if (typeof value !== 'number') throw new TypeError(`${name}: ${String(value)} is not a number`);
  if (NUMBERS.get(name) === true && !(Number.isInteger(value) && value >= 0 && value <= MOST_UINT32)) {
    throw new RangeError(`${name}: ${value} is not a whole number from 0 to ${MOST_UINT32}`);
  }
  return value;
}

/** RangeError for unknown names. */
export function checkedOutputs(outputs: readonly Output[]): readonly Output[] {
  outputs.forEach((name) => oneOf('outputs', name, OUTPUTS));
  return outputs;
}

/** Which arrays the answer shall hold. `compressed`: the server may compress them. */
export function outputsMessage(outputs: readonly Output[], compressed: boolean): Outputs {
  const message = create(OutputsSchema);
  for (const name of checkedOutputs(outputs)) message[name] = true;
  if (compressed && hasZstd()) message.acceptedCompressions = [Compression.ZSTD];
  return message;
}

/** The options that are set, by name, without method and preset. */
export function numbersOf(message: SegmentOptions | undefined): Record<string, number> {
  const numbers: Record<string, number> = {};
  if (message === undefined) return numbers;
  for (const name of NUMBERS.keys()) {
    const value = (message as unknown as Record<string, unknown>)[name];
    if (typeof value === 'number') numbers[name] = value;
  }
  if (message.cut.case !== undefined) numbers[message.cut.case] = message.cut.value;
  return numbers;
}
