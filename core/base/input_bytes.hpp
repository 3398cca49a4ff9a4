// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

#include "absl/status/statusor.h"
#include "segserve/stop_token.hpp"

namespace segserve {

/// All bytes of an input that somebody named: a file, a pipe, or standard input for "-". /dev/stdin, /dev/fd/N and
/// /proc/self/fd/N are read as standard input is, whatever they are. A pipe may have no writer yet. Reading ends after
/// most_bytes + 1 bytes, which tell that there are too many.
///
/// NOT_FOUND if there is no such file; PERMISSION_DENIED if it may not be read; INVALID_ARGUMENT for what is no file
/// and has no end: a folder, a device, a socket; CANCELLED or DEADLINE_EXCEEDED within a tenth of a second after `stop`
/// says so; UNAVAILABLE if reading fails. The message does not name the path: "it is a character device".
absl::StatusOr<std::string> read_input_bytes(const std::string& path, std::uint64_t most_bytes,
                                             const StopToken& stop = {});

}  // namespace segserve
