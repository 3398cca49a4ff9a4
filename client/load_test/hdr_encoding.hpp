// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "client/load_test/hdr_histogram.hpp"

// The bytes of histograms as all implementations of HdrHistogram exchange them: "V2", a header and the counts, in which
// runs of zeros are one number, compressed by zlib and written in base64. The format is that of
// encodeIntoCompressedByteBuffer in https://github.com/HdrHistogram/HdrHistogram.
namespace segserve::bench {

/// For example "HISTFAAAACZ4nJNpmSzMwMDAyQABTBDMCGMDAEJ7AP8=".
std::string to_hdr_base64(const HdrHistogram& histogram);

/// The histogram of such a text, if it has 3 significant digits and values of at most HdrHistogram::kHighest. Mean and
/// maximum are those of the buckets. INVALID_ARGUMENT if it is not one.
absl::StatusOr<HdrHistogram> from_hdr_base64(std::string_view text);

}  // namespace segserve::bench
