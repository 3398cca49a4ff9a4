// SPDX-License-Identifier: Apache-2.0
// segserve for Node.
import './node/platform.js';

export * from './common.js';
export {OutageError} from './errors.js';
export {Client, type StreamArguments} from './node/client.js';
export {type Pem, type Tls} from './node/credentials.js';
export {type ClientOptions} from './node/settings.js';
export {Stream} from './node/stream.js';
export {type FrameReport, type Order, Outcome, type OutcomeKind, STREAM_DEFAULTS, type StreamRules,
        type WhenBehind} from './stream/frame.js';
export {type FrameArguments} from './stream/frame_request.js';
