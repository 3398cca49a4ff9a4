// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <random>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "segserve/client/stream_options.hpp"

namespace segserve::client {

/// Splits a list at its commas: "a:1, b:2" holds two addresses. A host without a port gets the default one, 50051. A
/// name that gRPC resolves ("dns:///name:50051", "unix:/path") is one address even if it stands for many servers.
/// INVALID_ARGUMENT if there is no address, or one of them is empty, a URL, or has no number as its port.
absl::StatusOr<std::vector<std::string>> parse_addresses(std::string_view text);

/// The random time to wait before the `attempt`-th repetition, counted from 1: see RetryOptions. `asked_for` is the
/// time that the server asked for.
std::chrono::milliseconds backoff(const RetryOptions& retry, std::uint32_t attempt,
                                  std::optional<std::chrono::milliseconds> asked_for, std::minstd_rand& random);

/// Chooses which of several addresses to try next, and when.
class AddressBook {
 public:
  /// `count` is the number of addresses, above 0; begins with address `first` modulo `count`.
  AddressBook(std::size_t count, std::size_t first, RetryOptions retry, std::uint32_t seed);

  struct Choice {
    std::size_t address = 0;
    Time not_before = {};
  };
  /// The address that may be tried soonest. If several may be tried at that time, the next in turn.
  Choice choose(Time now) const;

  /// The server could not be reached, broke the connection, or refuses us, and may have asked to wait. The turn goes on
  /// to the next address.
  void failed(std::size_t address, Time now, std::optional<std::chrono::milliseconds> asked_for);
  /// The server answered.
  void reached(std::size_t address);
  /// True if every address has failed since it was reached last.
  bool nobody_in_reach() const;

 private:
  struct Entry {
    std::uint32_t failures = 0;  // since it was reached last
    Time not_before = {};
  };
  RetryOptions retry_;
  std::minstd_rand random_;
  std::vector<Entry> entries_;
  std::size_t turn_;
};

}  // namespace segserve::client
