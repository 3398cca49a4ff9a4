// SPDX-License-Identifier: Apache-2.0
#include "client/stream/address_book.hpp"

#include <algorithm>

#include "fmt/format.h"

namespace segserve::client {
namespace {

std::string_view trimmed(std::string_view text) {
  const std::size_t begin = text.find_first_not_of(" \t");
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(" \t") - begin + 1);
}

}  // namespace

absl::StatusOr<std::vector<std::string>> parse_addresses(std::string_view text) {
  if (trimmed(text).empty()) return absl::InvalidArgumentError("the server's address is empty");
  std::vector<std::string> addresses;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    const std::string_view address = trimmed(text.substr(begin, end - begin));
    if (address.empty()) return absl::InvalidArgumentError(fmt::format("there is an empty address in '{}'", text));
    addresses.emplace_back(address);
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
