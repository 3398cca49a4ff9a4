// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "segserve/client/cloud_fingerprint.hpp"
#include "segserve/client/frame.hpp"

namespace segserve::client {

/// Encodes a result as a file, from which any cut can be made later without the server. The file is one line of text,
///
///     segserve-result 3 <payload bytes, decimal> <CRC-32 of the payload> <coordinates> <colors>\n
///
/// where `coordinates` and `colors` are the fingerprint of the cloud, and the three checksums have 8 hexadecimal digits
/// each; and the payload: a segserve.v1.SegmentResponse whose result has labels, supervoxels and tree (their blocks
/// compressed by zstd where that is smaller), and the statistics of the segments if the result has them. Other programs
/// drop the first line and parse the rest.
///
/// INVALID_ARGUMENT if the result is too large for one message (2 GiB).
absl::StatusOr<std::string> encode_result_file(const Result& result, const CloudFingerprint& cloud);

/// Encodes a result without a fingerprint. Its first line is of version 2, which ends after the CRC-32 of the payload.
/// Nothing then tells whether a cloud is the one that was segmented.
absl::StatusOr<std::string> encode_result_file(const Result& result);

/// The fingerprint in the first line of such a file; unset if the line is of version 2. INVALID_ARGUMENT if the line is
/// none of either.
absl::StatusOr<std::optional<CloudFingerprint>> fingerprint_in_result_file(std::string_view bytes);

/// Decodes such a file, of version 2 or 3; the bytes need not be trusted. INVALID_ARGUMENT with one line that says what
/// is wrong: the file is foreign, of another version, truncated or damaged, or its arrays do not fit each other.
absl::StatusOr<Result> decode_result_file(std::string_view bytes);

}  // namespace segserve::client
