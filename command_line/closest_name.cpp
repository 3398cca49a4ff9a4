// SPDX-License-Identifier: Apache-2.0
#include "command_line/closest_name.hpp"

#include <algorithm>
#include <numeric>
#include <utility>
#include <vector>

namespace segserve {
namespace {

std::string_view without_dashes(std::string_view name) {
  return name.substr(std::min(name.find_first_not_of('-'), name.size()));
}

}  // namespace

std::size_t edit_distance(std::string_view a, std::string_view b) {
  // Rows of the table of distances between the first letters of a and the first letters of b.
  std::vector<std::size_t> before_last, last(b.size() + 1), row(b.size() + 1);
  std::iota(last.begin(), last.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t replaced = last[j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1);
      row[j] = std::min({last[j] + 1, row[j - 1] + 1, replaced});
      const bool swapped = i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1];
      if (swapped) row[j] = std::min(row[j], before_last[j - 2] + 1);
    }
    before_last = std::exchange(last, row);
  }
  return last[b.size()];
}

std::optional<std::string> closest_name(std::string_view typed, std::span<const std::string> names) {
  constexpr std::size_t kMostLetters = 64;  // of a name; the time for longer ones would be wasted
  constexpr std::size_t kLeastPrefix = 3;
  typed = without_dashes(typed);
  if (typed.empty() || typed.size() > kMostLetters || names.empty()) return std::nullopt;
  const auto distance = [typed](const std::string& name) { return edit_distance(typed, without_dashes(name)); };
  const auto closest = std::ranges::min_element(names, {}, distance);
  if (distance(*closest) <= std::max<std::size_t>(1, typed.size() / 3)) return *closest;
  if (typed.size() < kLeastPrefix) return std::nullopt;
  const auto begun =
      std::ranges::find_if(names, [typed](std::string_view name) { return without_dashes(name).starts_with(typed); });
  return begun == names.end() ? std::nullopt : std::optional(*begun);
}

}  // namespace segserve
