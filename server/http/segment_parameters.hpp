// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "proto/wire/request_message.hpp"
#include "segserve/codec/read_options.hpp"
#include "segserve/codec/rgbd.hpp"
#include "segserve/options.hpp"

namespace segserve::server {

/// The parameters in the query of POST /v1/segment.
struct SegmentParameters {
  /// Options and prompts. `outputs.labels` is whether labels were asked for by name.
  wire::ParsedRequest request;
  codec::ReadOptions read;                                 ///< of a file
  std::optional<codec::Intrinsics> intrinsics = {};        ///< of the depth image
  std::optional<codec::Intrinsics> color_intrinsics = {};  ///< of the color image
  std::optional<double> depth_scale = {};                  ///< meters a unit of depth
  std::string request_id = {};                             ///< for the log
  std::string name = {};                                   ///< of the scene, for people
  std::optional<std::chrono::milliseconds> timeout = {};   ///< from the arrival of the request
};

/// Whether a query may have a parameter of this name.
bool is_segment_parameter(std::string_view name);

/// Reads a query such as "threshold=0.5&outputs=segments,labels&include=320,240". The options have the names that
/// option_table() has. INVALID_ARGUMENT, INVALID_FIELD names every parameter that is wrong or unknown, and
/// what was meant, if that is plain.
absl::StatusOr<SegmentParameters> parse_segment_parameters(std::string_view query, const Options& defaults);

}  // namespace segserve::server
