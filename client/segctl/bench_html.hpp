// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "CLI/CLI.hpp"
#include "absl/status/status.h"
#include "client/segctl/staged_output.hpp"
#include "nlohmann/json_fwd.hpp"

namespace segserve::segctl {

/// The flag --html of segctl bench: a page that shows a load test in charts and tables. It must outlive the parsing of
/// the command line.
class BenchHtmlFlag {
 public:
  void add_to(CLI::App& app);

  bool given() const { return !path_.empty(); }

  /// Announces the page (StagedOutput::announce) if the flag was given. INVALID_ARGUMENT if this segctl has no pages.
  absl::Status announce(StagedOutput& output) const;

  /// Adds the page if the flag was given. `run` is what segctl bench --json writes.
  absl::Status add(StagedOutput& output, const nlohmann::ordered_json& run) const;

 private:
  std::string path_;
};

}  // namespace segserve::segctl
