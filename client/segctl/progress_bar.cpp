// SPDX-License-Identifier: Apache-2.0
#include "client/segctl/progress_bar.hpp"

#include <unistd.h>

#include <cstdio>
#include <utility>

#include "fmt/format.h"

namespace segserve::segctl {

ProgressBar::ProgressBar(std::string task) : task_(std::move(task)), on_terminal_(isatty(STDERR_FILENO) == 1) {}

ProgressBar::~ProgressBar() {
  if (on_terminal_) std::fputs("\r\033[K", stderr);
}

void ProgressBar::show(std::size_t done, std::size_t all) const {
  if (!on_terminal_) return;
  constexpr std::size_t kWidth = 40;
  const std::size_t filled = all == 0 ? kWidth : kWidth * done / all;
  const std::string line = fmt::format("\r{} [{:-<{}}] {}/{}", task_, std::string(filled, '#'), kWidth, done, all);
  std::fputs(line.c_str(), stderr);
  std::fflush(stderr);
}

}  // namespace segserve::segctl
