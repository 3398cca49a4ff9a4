// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "CLI/CLI.hpp"

namespace segserve::segctl {

/// The flag --traceparent, by which servers note the calls of this command as parts of a distributed trace. It must
/// outlive the parsing of the command line.
class TraceFlag {
 public:
  /// Without the flag, a valid environment variable TRACEPARENT counts; one that is not valid is ignored, as W3C's
  /// Trace Context wants it.
  void add_to(CLI::App& app);

  /// Whether the flag was given; the environment does not count.
  bool given() const { return option_->count() > 0; }
  /// Valid, or empty.
  const std::string& traceparent() const { return traceparent_; }

  /// Tells on standard error which trace was begun, if "--traceparent new" began one.
  void announce() const;

 private:
  std::string traceparent_;
  bool is_new_ = false;
  CLI::Option* option_ = nullptr;
};

}  // namespace segserve::segctl
