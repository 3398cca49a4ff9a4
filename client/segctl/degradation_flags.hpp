// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "CLI/CLI.hpp"
#include "core/lab/eval/degrade.hpp"

namespace segserve::segctl {

/// The flags --scale, --noise-mm, --keep, --no-color and --seed. It must outlive the parsing of the command line.
class DegradationFlags {
 public:
  void add_to(CLI::App& app);
  eval::Degradation degradation() const;

 private:
  eval::Degradation degradation_;
  bool no_color_ = false;
};

}  // namespace segserve::segctl
