#pragma once

#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "segserve/client/client.hpp"

namespace segserve::client {

/// A result as a file, from which any cut can be made later without the server. One line of text,
///
///     segserve-result 2 <payload bytes, decimal> <CRC-32 of the payload, 8 hexadecimal digits>\n
///
/// then the payload: a segserve.v1.SegmentResponse whose result has labels, supervoxels
/// and tree (their blocks zstd-compressed where that is smaller), and the segments' statistics if it had them. To read
/// it elsewhere, drop the first line and parse the rest.
absl::StatusOr<std::string> encode_result_file(const Result& result);

/// The inverse, for untrusted bytes. INVALID_ARGUMENT with one line that says what is wrong: a
/// foreign file, another version, truncated, damaged, or arrays that do not fit each other.
absl::StatusOr<Result> decode_result_file(std::string_view bytes);

}  // namespace segserve::client
