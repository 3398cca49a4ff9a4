// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "segserve/client/frame.hpp"
#include "segserve/v1/result.pb.h"

namespace segserve::client {

/// An outcome whose result may still be a message, because decoding takes long and is done on the thread that takes the
/// outcome.
struct UndecodedOutcome {
  Outcome outcome;
  v1::SegmentationResult message;  ///< of a kResult from a server
  std::uint64_t points = 0;        ///< of the cloud that was sent; 0: only the server knows
  wire::Outputs outputs;           ///< what the frame asked for
  bool wants_tracks = false;       ///< likewise
};

/// The outcome as the application gets it. It becomes kFailed with INTERNAL if the server's result is broken, and with
/// RESOURCE_EXHAUSTED if there is not enough memory for it.
Outcome decode(UndecodedOutcome undecoded);

}  // namespace segserve::client
