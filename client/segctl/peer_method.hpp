// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "absl/status/statusor.h"
#include "core/lab/eval/evaluation.hpp"

namespace segserve::segctl {

/// A method of others that segctl eval sets beside ours.
struct PeerMethod {
  std::string name;  ///< Of its report.
  eval::SegmentScene segment;
};

/// The method that --peer names. "lccp" is PCL's VCCS and LCCP with the settings of core/lab/eval/README.md, and
/// "lccp:V,S" the same with voxels of V and seeds of S meters, 0 < V <= S. INVALID_ARGUMENT for any other text, and if
/// segctl was built without PCL. UNAVAILABLE if PCL cannot be loaded.
absl::StatusOr<PeerMethod> peer_method(const std::string& text);

}  // namespace segserve::segctl
