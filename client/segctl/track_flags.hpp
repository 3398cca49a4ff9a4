// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "CLI/CLI.hpp"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "segserve/client/client.hpp"
#include "segserve/tracking.hpp"

namespace segserve::segctl {

/// The flags --track, --rate, --no-poses, --max-speed and --keep-lost. It must outlive the parsing of the command line.
struct TrackFlags {
  bool track = false;
  double rate = 10;
  bool no_poses = false;
  TrackOptions options;

  void add_to(CLI::App& app, const std::string& description);
  /// INVALID_ARGUMENT that names every flag that is out of its range.
  absl::Status check() const;
};

/// The numbers to write for the points of a result: the ids of their tracks if it has such, or else their labels.
std::vector<std::uint32_t> shown_labels(const client::Result& result);

}  // namespace segserve::segctl
