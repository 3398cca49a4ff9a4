// SPDX-License-Identifier: Apache-2.0
// The abilities and limits of a server.
import {Compression} from './gen/segserve/v1/block_pb.js';
import {type GetServerInfoResponse} from './gen/segserve/v1/segmentation_service_pb.js';
import {PayloadKind} from './gen/segserve/v1/server_info_pb.js';
import {methodName, numbersOf} from './options.js';

/** A numeric option of the segmentation. */
export interface OptionInfo {
  /** As the server and segctl name it, such as "voxel_resolution"; here it is "voxelResolution". */
  readonly name: string;
  /** Empty if the option has none. */
  readonly unit: string;
  readonly description: string;
  readonly minimum: number;
  readonly maximum: number;
  /** Undefined if the option is off. */
  readonly defaultValue?: number;
}

/** What a server can do, and its limits. */
export interface ServerInfo {
  readonly version: string;
  /** The kinds that it decodes, such as "planar" and "pcd_file". */
  readonly payloads: readonly string[];
  /** Such as "zstd". */
  readonly compressions: readonly string[];
  /** By the names of segserve.v1.Limits, such as "maxPoints". */
  readonly limits: Readonly<Record<string, number>>;
  readonly defaultMethod: string;
  /** The options of a call that sets none, by name. */
  readonly defaultOptions: Readonly<Record<string, number>>;
  /** For each method the options of a call that sets nothing but the method. */
  readonly methods: Readonly<Record<string, Readonly<Record<string, number>>>>;
  /** By name. */
  readonly options: Readonly<Record<string, OptionInfo>>;
}

/** @internal */
export function serverInfo(message: GetServerInfoResponse): ServerInfo {
  const numbers = Object.entries(message.limits ?? {}).filter(([, value]) => ['number', 'bigint'].includes(typeof value));
  return {
    version: message.version,
    payloads: message.payloadKinds.map((kind) => (PayloadKind[kind] ?? String(kind)).toLowerCase()),
    compressions: message.compressions.map((kind) => (Compression[kind] ?? String(kind)).toLowerCase()),
    limits: Object.fromEntries(numbers.map(([name, value]) => [name, Number(value)])),
    defaultMethod: message.defaultOptions === undefined ? '' : methodName(message.defaultOptions.method),
    defaultOptions: numbersOf(message.defaultOptions),
    methods: Object.fromEntries(message.methods.map(({name, defaults}) => [name, numbersOf(defaults)])),
    options: Object.fromEntries(message.options.map((option) => [camelCase(option.name), {
      name: option.name,
      unit: option.unit,
      description: option.description,
      minimum: option.minimum,
      maximum: option.maximum,
      defaultValue: option.defaultValue,
    }])),
  };
}

function camelCase(name: string): string {
  return name.replace(/_([a-z])/g, (_, letter: string) => letter.toUpperCase());
}
