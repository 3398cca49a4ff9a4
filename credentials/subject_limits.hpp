// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>

namespace segserve::credentials {

/// The limits of a subject. A limit that is unset, or a rate that is infinite, does not exist.
struct SubjectLimits {
  std::optional<double> frames_per_second = std::nullopt;       ///< above 0; a burst holds those of one second
  std::optional<double> points_per_second = std::nullopt;       ///< above 0; a burst holds those of one second
  std::optional<std::uint64_t> bytes_in_flight = std::nullopt;  ///< above 0; of payloads whose frames have not ended
  std::optional<std::int32_t> highest_priority = std::nullopt;  ///< higher priorities of frames are lowered to it

  friend bool operator==(const SubjectLimits&, const SubjectLimits&) = default;
};

}  // namespace segserve::credentials
