// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "segserve/client/frame.hpp"

namespace segserve::client {

/// Encodes a result as a file, from which any cut can be made later without the server. The file is one line of text,
///
///     segserve-result 2 <payload bytes, decimal> <CRC-32 of the payload, 8 hexadecimal digits>\n
///
/// and the payload: a segserve.v1.SegmentResponse whose result has labels, supervoxels and tree (their blocks
/// compressed by zstd where that is smaller), and the statistics of the segments if the result has them. Other programs
/// drop the first line and parse the rest.
///
/// INVALID_ARGUMENT if the result is too large for one message (2 GiB).
absl::StatusOr<std::string> encode_result_file(const Result& result);

/// Decodes such a file; the bytes need not be trusted. INVALID_ARGUMENT with one line that says what is wrong: the file
/// is foreign, of another version, truncated or damaged, or its arrays do not fit each other.
absl::StatusOr<Result> decode_result_file(std::string_view bytes);

}  // namespace segserve::client
