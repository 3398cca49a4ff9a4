// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include "client/bench_report/live_view.hpp"

namespace segserve::segctl {

/// Whether standard error is a terminal that can move its cursor, and how wide its window is.
bool terminal_moves_cursor();
std::size_t terminal_columns();

/// Shows a load test on standard error while it goes on. It shows nothing unless standard error is a terminal that can
/// move its cursor, colors nothing if NO_COLOR is set, and follows the width of the window. The destructor wipes the
/// lines. Not thread-safe.
class LiveTerminal {
 public:
  /// `title` tells the load, e.g. "4 clients, planar".
  explicit LiveTerminal(std::string title);
  ~LiveTerminal();
  LiveTerminal(const LiveTerminal&) = delete;
  LiveTerminal& operator=(const LiveTerminal&) = delete;

  bool is_shown() const { return view_.has_value(); }
  void show_progress(double share);
  void show(const bench_report::LiveSnapshot& snapshot);

 private:
  void redraw();

  std::optional<bench_report::LiveView> view_;  // none if nothing is shown
  int shown_percent_ = -1;
};

}  // namespace segserve::segctl
