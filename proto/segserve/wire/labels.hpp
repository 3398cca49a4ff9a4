#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "segserve/v1alpha1/result.pb.h"

namespace segserve::wire {

/// The labels with as few bytes each as their maximum allows.
absl::StatusOr<v1alpha1::LabelArray> to_message(std::span<const std::uint32_t> labels,
                                                v1alpha1::Compression compression);

/// The labels of exactly `points` points, all of them at most `maximum`. MALFORMED_PAYLOAD, naming the array by
/// `name`, if the message holds anything else.
absl::StatusOr<std::vector<std::uint32_t>> from_message(const v1alpha1::LabelArray& message, std::uint64_t points,
                                                        std::uint32_t maximum, std::string_view name);

}  // namespace segserve::wire
