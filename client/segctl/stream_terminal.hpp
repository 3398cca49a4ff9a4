// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>

namespace segserve::segctl {

/// Lines on standard error that are drawn over themselves. It shows nothing unless standard error is a terminal that
/// can move its cursor. The destructor wipes the lines. Not thread-safe.
class StreamTerminal {
 public:
  StreamTerminal();
  ~StreamTerminal();
  StreamTerminal(const StreamTerminal&) = delete;
  StreamTerminal& operator=(const StreamTerminal&) = delete;

  bool is_shown() const { return is_shown_; }
  /// The width of the window.
  std::size_t columns() const;
  /// Draws these lines, each with a line feed behind it and shorter than the window, in place of those before.
  void show(const std::string& lines);

 private:
  void wipe();

  const bool is_shown_;
  std::size_t drawn_lines_ = 0;
};

}  // namespace segserve::segctl
