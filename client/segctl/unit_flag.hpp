// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "CLI/CLI.hpp"
#include "segserve/codec/length_unit.hpp"

namespace segserve::segctl {

/// The flag --unit. It must outlive the parsing of the command line.
class UnitFlag {
 public:
  void add_to(CLI::App& app, const std::string& group);
  bool given() const { return option_ != nullptr && option_->count() > 0; }
  codec::LengthUnit unit() const { return *codec::length_unit_from_name(name_); }

 private:
  std::string name_ = "m";
  CLI::Option* option_ = nullptr;
};

}  // namespace segserve::segctl
