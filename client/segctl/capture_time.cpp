// SPDX-License-Identifier: Apache-2.0
#include "client/segctl/capture_time.hpp"

#include <algorithm>
#include <cstddef>

#include "absl/strings/ascii.h"
#include "absl/strings/numbers.h"

namespace segserve::segctl {
namespace {

constexpr std::size_t kFewestDecimals = 3;

std::size_t digits_at(std::string_view text) {
  return static_cast<std::size_t>(std::ranges::find_if_not(text, absl::ascii_isdigit) - text.begin());
}

/// How many of its units are a second, for a whole number of so many digits; 0 for a number that is no time.
double units_per_second(std::size_t digits) {
  switch (digits) {
    case 13:
      return 1e3;
    case 16:
      return 1e6;
    case 19:
      return 1e9;
    default:
      return 0;
  }
}

}  // namespace

std::optional<double> capture_time(std::string_view file_name) {
  file_name.remove_prefix(
      static_cast<std::size_t>(std::ranges::find_if(file_name, absl::ascii_isdigit) - file_name.begin()));
  const std::size_t whole = digits_at(file_name);
  const std::string_view rest = file_name.substr(whole);
  const std::size_t decimals = rest.starts_with('.') ? digits_at(rest.substr(1)) : 0;
  const bool is_seconds = whole > 0 && decimals >= kFewestDecimals;
  const std::size_t length = is_seconds ? whole + 1 + decimals : whole;
  // Nothing but the extension may follow.
  if (length < file_name.size() && file_name[length] != '.') return std::nullopt;
  const double units = is_seconds ? 1 : units_per_second(whole);
  double number = 0;
  if (units == 0 || !absl::SimpleAtod({file_name.data(), length}, &number)) return std::nullopt;
  return number / units;
}

}  // namespace segserve::segctl
