#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"

namespace segserve::codec {

/// One unsigned little-endian integer per point, all of the same width.
struct EncodedLabels {
  std::string bytes;
  std::uint32_t bytes_per_label = 1;  ///< 1, 2 or 4: the smallest that holds the largest label
};

EncodedLabels encode_labels(std::span<const std::uint32_t> labels);

/// INVALID_ARGUMENT if `bytes_per_label` is not 1, 2 or 4, or `bytes` does not hold whole labels.
absl::StatusOr<std::vector<std::uint32_t>> decode_labels(std::string_view bytes, std::uint32_t bytes_per_label);

}  // namespace segserve::codec
