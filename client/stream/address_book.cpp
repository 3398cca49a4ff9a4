// SPDX-License-Identifier: Apache-2.0
#include "client/stream/address_book.hpp"

#include <algorithm>
#include <array>
#include <charconv>

#include "core/base/status_macros.hpp"
#include "fmt/format.h"

namespace segserve::client {
namespace {

std::string_view trimmed(std::string_view text) {
  const std::size_t begin = text.find_first_not_of(" \t");
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(" \t") - begin + 1);
}

/// Whether gRPC resolves the name by a rule of its own, instead of as HOST:PORT.
bool has_resolver(std::string_view address) {
  constexpr std::array<std::string_view, 7> kSchemes{
      "dns:", "unix:", "unix-abstract:", "ipv4:", "ipv6:", "passthrough:", "xds:"};
  return std::ranges::any_of(kSchemes, [address](std::string_view scheme) { return address.starts_with(scheme); });
}

absl::StatusOr<std::string> with_port(std::string_view address) {
  constexpr std::string_view kDefaultPort = "50051";
  if (has_resolver(address)) return std::string(address);
  if (address.find("://") != std::string_view::npos || address.find('/') != std::string_view::npos) {
    return absl::InvalidArgumentError(fmt::format(
        "'{}' is a URL; the address of a server is HOST:PORT, such as 127.0.0.1:{}", address, kDefaultPort));
  }
  const bool is_bare_ipv6 = !address.starts_with('[') && std::ranges::count(address, ':') > 1;
  if (is_bare_ipv6) return fmt::format("[{}]:{}", address, kDefaultPort);
  const std::size_t colon = address.rfind(':');
  if (colon == std::string_view::npos || address.ends_with(']')) return fmt::format("{}:{}", address, kDefaultPort);
  unsigned port = 0;
  const char* const end = address.data() + address.size();
  const auto parsed = std::from_chars(address.data() + colon + 1, end, port);
  if (parsed.ec != std::errc{} || parsed.ptr != end || port == 0 || port > 65535) {
    return absl::InvalidArgumentError(fmt::format("the port of '{}' is no number from 1 to 65535", address));
  }
  return std::string(address);
}

}  // namespace

absl::StatusOr<std::vector<std::string>> parse_addresses(std::string_view text) {
  if (trimmed(text).empty()) return absl::InvalidArgumentError("the server's address is empty");
  std::vector<std::string> addresses;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    const std::string_view address = trimmed(text.substr(begin, end - begin));
    if (address.empty()) return absl::InvalidArgumentError(fmt::format("there is an empty address in '{}'", text));
    ASSIGN_OR_RETURN(addresses.emplace_back(), with_port(address));
    begin = end + 1;
  }
  return addresses;
}

std::chrono::milliseconds backoff(const RetryOptions& retry, std::uint32_t attempt,
                                  std::optional<std::chrono::milliseconds> asked_for, std::minstd_rand& random) {
  constexpr std::uint32_t kMostDoublings = 20;
  const std::uint32_t doublings = std::min(std::max(attempt, 1U) - 1, kMostDoublings);
  const double full = std::min(static_cast<double>(retry.first_backoff.count()) * static_cast<double>(1U << doublings),
                               static_cast<double>(retry.max_backoff.count()));
  const double share = std::uniform_real_distribution<double>(0.5, 1.0)(random);
  const auto wait = std::chrono::milliseconds(static_cast<std::int64_t>(full * share));
  return std::max(wait, asked_for.value_or(wait));
}

AddressBook::AddressBook(std::size_t count, std::size_t first, RetryOptions retry, std::uint32_t seed)
    : retry_(retry), random_(seed), entries_(count), turn_(first % count) {}

AddressBook::Choice AddressBook::choose(Time now) const {
  const auto when = [&](std::size_t address) { return std::max(now, entries_[address].not_before); };
  Choice best{turn_, when(turn_)};
  for (std::size_t i = 1; i < entries_.size(); ++i) {
    const std::size_t address = (turn_ + i) % entries_.size();
    if (when(address) < best.not_before) best = {address, when(address)};
  }
  return best;
}

void AddressBook::failed(std::size_t address, Time now, std::optional<std::chrono::milliseconds> asked_for) {
  Entry& entry = entries_[address];
  ++entry.failures;
  entry.not_before = now + backoff(retry_, entry.failures, asked_for, random_);
  turn_ = (address + 1) % entries_.size();
}

void AddressBook::reached(std::size_t address) {
  entries_[address] = {};
  turn_ = address;
}

bool AddressBook::nobody_in_reach() const {
  return std::ranges::all_of(entries_, [](const Entry& entry) { return entry.failures > 0; });
}

}  // namespace segserve::client
