// SPDX-License-Identifier: Apache-2.0
#include "proto/wire/traceparent.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <random>

#include "absl/strings/escaping.h"
#include "fmt/format.h"

namespace segserve::wire {
namespace {

constexpr std::size_t kTraceIdDigits = 32, kSpanIdDigits = 16;
constexpr std::string_view kVersion = "00-";

bool is_hex(std::string_view text) {
  return std::ranges::all_of(text, [](char c) { return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f'); });
}

bool is_id(std::string_view text) { return is_hex(text) && text.find_first_not_of('0') != std::string_view::npos; }

/// 16 digits, not all 0.
std::string random_digits() {
  thread_local std::mt19937_64 random = [] {
    std::random_device device;
    std::seed_seq seed{device(), device(), device(), device(), device(), device(), device(), device()};
    return std::mt19937_64(seed);
  }();
  std::uint64_t number = 0;
  while (number == 0) number = random();
  return fmt::format("{:016x}", number);
}

}  // namespace

std::optional<Traceparent> parse_traceparent(std::string_view text) {
  constexpr std::size_t kSpanIdBegin = kVersion.size() + kTraceIdDigits + 1;
  constexpr std::size_t kFlagsBegin = kSpanIdBegin + kSpanIdDigits + 1, kFlagDigits = 2;
  const bool has_shape = text.size() == kFlagsBegin + kFlagDigits && text.starts_with(kVersion) &&
                         text[kSpanIdBegin - 1] == '-' && text[kFlagsBegin - 1] == '-';
  if (!has_shape) return std::nullopt;
  const std::string_view trace_id = text.substr(kVersion.size(), kTraceIdDigits);
  const std::string_view span_id = text.substr(kSpanIdBegin, kSpanIdDigits), flags = text.substr(kFlagsBegin);
  if (!is_id(trace_id) || !is_id(span_id) || !is_hex(flags)) return std::nullopt;
  // The last bit of the flags is the only one that version 00 knows.
  const bool is_sampled = std::string_view("13579bdf").find(flags.back()) != std::string_view::npos;
  return Traceparent{.trace_id = std::string(trace_id), .span_id = std::string(span_id), .is_sampled = is_sampled};
}

std::string to_text(const Traceparent& traceparent) {
  return fmt::format("{}{}-{}-{}", kVersion, traceparent.trace_id, traceparent.span_id,
                     traceparent.is_sampled ? "01" : "00");
}

absl::Status check_traceparent(std::string_view text) {
  if (text.empty() || parse_traceparent(text)) return absl::OkStatus();
  return absl::InvalidArgumentError(
      fmt::format("traceparent: \"{}\" is not of the form 00-<32 digits>-<16 digits>-<2 digits>, hexadecimal in lower "
                  "case and neither of the first two all 0",
                  absl::CHexEscape({text.data(), text.size()})));
}

std::string new_trace_id() { return random_digits() + random_digits(); }

std::string new_span_id() { return random_digits(); }

}  // namespace segserve::wire
