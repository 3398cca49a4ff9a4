#pragma once

#include <optional>
#include <string>
#include <vector>

#include "CLI/CLI.hpp"
#include "absl/status/statusor.h"
#include "segserve/options.hpp"

namespace segserve::segctl {

/// The segmentation options as flags: --method, and one flag per row of `option_table()` with its
/// meaning, unit, range and default in the help ("voxel_resolution" is --voxel-resolution).
/// Must outlive the parsing of the command line.
class OptionFlags {
 public:
  /// All of them.
  void add_to(CLI::App& app);
  /// Only --threshold and --regions, for those who cut and do not segment.
  void add_cut_to(CLI::App& app);

  /// What was given, over the defaults. INVALID_ARGUMENT naming every wrong option at once.
  absl::StatusOr<Options> options() const;

 private:
  struct Flag {
    const OptionInfo* option = nullptr;
    std::optional<double> value;
  };
  void add_number(CLI::App& app, const OptionInfo& option, Flag& flag);

  std::string method_;
  std::vector<Flag> flags_;
};

}  // namespace segserve::segctl
