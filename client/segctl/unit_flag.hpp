// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "CLI/CLI.hpp"
#include "segserve/codec/length_unit.hpp"

namespace segserve::segctl {

/// The flag --unit. It must outlive the parsing of the command line.
class UnitFlag {
 public:
  void add_to(CLI::App& app, const std::string& group);
  bool given() const { return option_ != nullptr && option_->count() > 0; }
  /// Unset if the flag is not given: then the file may say it.
  std::optional<codec::LengthUnit> unit() const { return codec::length_unit_from_name(name_); }

 private:
  std::string name_;
  CLI::Option* option_ = nullptr;
};

}  // namespace segserve::segctl
