// SPDX-License-Identifier: Apache-2.0
#include "client/load_test/fault_mix.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>
#include <string>

#include "fmt/format.h"

namespace segserve::bench {
namespace {

constexpr std::size_t kMostReaders = 100;

std::optional<double> parse_percent(std::string_view text) {
  double percent = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), percent);
  const bool is_percent = error == std::errc{} && std::string_view(end, text.data() + text.size()) == "%";
  if (!is_percent || !std::isfinite(percent) || percent < 0 || percent > 100) return std::nullopt;
  return percent / 100;
}

std::optional<std::size_t> parse_count(std::string_view text) {
  std::size_t count = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), count);
  if (error != std::errc{} || end != text.data() + text.size() || count > kMostReaders) return std::nullopt;
  return count;
}

/// Adds "KIND=AMOUNT" to the mix. Returns what is wrong with it, or an empty string.
std::string add_fault(std::string_view word, FaultMix& mix) {
  const std::size_t equals = word.find('=');
  const std::string_view kind = word.substr(0, equals);
  const std::string_view amount = equals == std::string_view::npos ? "" : word.substr(equals + 1);
  if (kind == "slow-reader") {
    const auto count = parse_count(amount);
    mix.slow_readers = count.value_or(0);
    return count ? "" : fmt::format("'{}' must be slow-reader=NUMBER, at most {}", word, kMostReaders);
  }
  double* share = kind == "vanish" ? &mix.vanish : kind == "malformed" ? &mix.malformed : nullptr;
  if (kind == "cancel") share = &mix.cancel;
  if (share == nullptr) return fmt::format("'{}' is none of slow-reader, vanish, malformed, cancel", kind);
  const auto percent = parse_percent(amount);
  *share = percent.value_or(0);
  return percent ? "" : fmt::format("'{}' must be {}=PERCENT%, from 0% to 100%", word, kind);
}

}  // namespace

absl::StatusOr<FaultMix> parse_fault_mix(std::string_view text) {
  FaultMix mix;
  std::string faults;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    const std::string fault = add_fault(text.substr(begin, end - begin), mix);
    if (!fault.empty()) faults += (faults.empty() ? "" : "; ") + fault;
    begin = end + 1;
  }
  if (!faults.empty()) return absl::InvalidArgumentError(fmt::format("--fault: {}", faults));
  return mix;
}

}  // namespace segserve::bench
