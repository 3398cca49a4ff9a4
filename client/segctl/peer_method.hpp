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

/// The method that --peer names; "lccp" is PCL's VCCS and LCCP with the settings of core/lab/eval/README.md.
/// INVALID_ARGUMENT for another name, and if segctl was built without PCL.
absl::StatusOr<PeerMethod> peer_method(const std::string& name);

}  // namespace segserve::segctl
