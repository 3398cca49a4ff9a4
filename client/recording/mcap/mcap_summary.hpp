// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "absl/status/statusor.h"
#include "client/recording/bytes/recording_file.hpp"
#include "client/recording/message_source.hpp"

namespace segserve::recording {

/// Reads schemas, channels and the number of messages from the summary at the end of an MCAP file. Nothing if the file
/// has none, one without these, one of more than 64 MiB, or a damaged one. UNAVAILABLE if reading fails.
absl::StatusOr<std::optional<Contents>> read_mcap_summary(RecordingFile& file);

}  // namespace segserve::recording
