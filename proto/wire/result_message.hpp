#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include "absl/status/statusor.h"
#include "proto/wire/request_message.hpp"
#include "segserve/segment.hpp"
#include "segserve/v1/result.pb.h"

namespace segserve::wire {

/// Wall times outside the segmentation, milliseconds (v1.Timings says from when to when).
struct CallTimings {
  double queue = 0;
  double decode = 0;
  double encode = 0;
  double total = 0;
};

/// A result as both ends of the wire know it.
struct Result {
  /// Arrays that were not asked for are empty. On the client `timings.total` is the sum of its stages.
  Segmentation segmentation;
  std::size_t points = 0;
  std::uint32_t supervoxels = 0;
  Method method = Method::kBorder;
  std::optional<std::uint32_t> regions;  ///< asked for; unset if the cut is at a threshold
  View view;                             ///< that was used
  std::string view_rule;                 ///< why this view, for people
  CallTimings timings;
  std::string server_version;    ///< of the program that segmented
  std::string options_hash;      ///< see wire::options_hash
  bool in_this_process = false;  ///< on the client: computed here, not by a server
};

/// What there is to tell of the finished segmentation of `cloud`; call timings are left 0.
Result make_result(Segmentation segmentation, const CloudView& cloud, const Options& options, std::string view_rule,
                   std::string version);

/// The message with the arrays that `outputs` asks for. Sets every timing but `encode` and `total`, which are
/// not known before: see set_final_timings.
absl::StatusOr<v1::SegmentationResult> to_message(const Result& result, const Outputs& outputs);

/// Fills in the two timings that end with the message itself.
void set_final_timings(v1::SegmentationResult& message, double encode_ms, double total_ms);

/// A result from a server for a cloud of `points` points. MALFORMED_PAYLOAD unless all its arrays fit the
/// cloud, the summary and each other.
absl::StatusOr<Result> from_message(const v1::SegmentationResult& message, std::size_t points);

}  // namespace segserve::wire
