// SPDX-License-Identifier: Apache-2.0
// The names that the package exports in Node and in browsers alike.
export {type Retry} from './address_book.js';
export {type CloudArrays, type Unit} from './cloud.js';
export {type Codec, CODECS, type PcdFile} from './codecs.js';
export {type CloudInput, type CloudOrPayload, encode, type Encoding} from './encode.js';
export {type ErrorCode, type ErrorDetails, type FieldViolation, SegserveError, TlsError} from './errors.js';
export {type OptionInfo, type ServerInfo} from './info.js';
export {DEFAULT_OUTPUTS, METHODS, type OptionName, type OptionValues, type Output, OUTPUTS,
        PRESETS, type Segmentation} from './options.js';
export {type Payload} from './payload.js';
export {type Pixel, type Place, type Position, type PromptedPoint, type Prompts} from './places.js';
export {type CallOptions, type SegmentArguments} from './requests.js';
export {type Echo, type OrientedBox, type Picked, type Placement, type Places, type Resolution, type Result,
        type ResultWarning, type Segment, type StageTimings, type SupportPlane, type Triple} from './result.js';
export {type Intrinsics, type Pixels, type RgbdImages} from './rgbd.js';
export {type Candidate} from './selection.js';
export {type Pose, type Tracking, type TrackRules} from './tracking.js';
export {type TrackEvent, type TrackEventKind, Tracks} from './tracks.js';
export {type Cut, MergeTree, type MergeTreeColumns, NO_NODE} from './tree.js';
export {type CameraPoints, type View, type ViewLike} from './view.js';
export {hasZstd, useZstd, type Zstd} from './zstd.js';
