// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "CLI/CLI.hpp"
#include "absl/status/statusor.h"
#include "segserve/prompts.hpp"

namespace segserve::segctl {

/// The flags that point at an object: --include, --exclude, --larger and --smaller. They must outlive the parsing of
/// the command line.
class PromptFlags {
 public:
  void add_to(CLI::App& app, bool required);
  bool given() const { return !include_.empty() || !exclude_.empty() || larger_ > 0 || smaller_ > 0; }
  /// Positions are in the coordinates and unit of the file. INVALID_ARGUMENT for a text that is no place, for too many,
  /// and if none is included.
  absl::StatusOr<Prompts> prompts() const;

 private:
  std::vector<std::string> include_, exclude_;
  std::int32_t larger_ = 0, smaller_ = 0;
};

}  // namespace segserve::segctl
