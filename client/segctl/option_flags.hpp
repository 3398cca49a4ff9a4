// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "CLI/CLI.hpp"
#include "absl/status/statusor.h"
#include "segserve/options.hpp"

namespace segserve::segctl {

/// The segmentation options as flags: --method, and one flag for each row of `option_table()` with its meaning, unit,
/// range and default in the help ("voxel_resolution" is --voxel-resolution). It must outlive the parsing of the command
/// line.
class OptionFlags {
 public:
  /// Adds a flag for every option.
  void add_to(CLI::App& app);
  /// Adds only --threshold and --regions, for a command that cuts a tree and does not segment.
  void add_cut_to(CLI::App& app);

  /// The defaults, overridden by the flags that were given. INVALID_ARGUMENT that names every wrong option at once.
  absl::StatusOr<Options> options() const;

 private:
  struct Flag {
    const OptionInfo* option = nullptr;
    std::optional<double> value;
  };
  void add_number(CLI::App& app, const OptionInfo& option, Flag& flag);

  std::string method_, preset_;
  std::vector<Flag> flags_;
};

}  // namespace segserve::segctl
