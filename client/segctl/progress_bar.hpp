// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>

namespace segserve::segctl {

/// A line on standard error that shows how far a long command is. It shows nothing unless standard error is a terminal.
/// The destructor wipes the line.
class ProgressBar {
 public:
  /// `task` is the word before the bar, e.g. "scoring".
  explicit ProgressBar(std::string task);
  ~ProgressBar();
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

  void show(std::size_t done, std::size_t all) const;

 private:
  std::string task_;
  bool on_terminal_;
};

}  // namespace segserve::segctl
