#pragma once

#include <cstddef>
#include <string>

namespace segserve::segctl {

/// A line on standard error that shows how far a long command is; nothing unless that is a terminal. The line is wiped
/// when the object goes.
class ProgressBar {
 public:
  explicit ProgressBar(std::string what);
  ~ProgressBar();
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

  void show(std::size_t done, std::size_t all) const;

 private:
  std::string what_;
  bool on_terminal_;
};

}  // namespace segserve::segctl
