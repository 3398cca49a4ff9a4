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

/// "a:1, b:2" are two addresses; what gRPC resolves ("dns:///name:50051", "unix:/path") is one, also when it
/// stands for many servers. INVALID_ARGUMENT for none, or an empty one among several.
absl::StatusOr<std::vector<std::string>> parse_addresses(std::string_view text);

/// A random wait before the `attempt`-th repetition (from 1): doubling, shortened by up to a half, never less than
/// what the server asked for.
std::chrono::milliseconds backoff(const RetryOptions& retry, std::uint32_t attempt,
                                  std::optional<std::chrono::milliseconds> asked_for, std::minstd_rand& random);

/// Which of several addresses to try next, and when.
class AddressBook {
 public:
  /// `first`: the address to begin with, modulo `count`.
  AddressBook(std::size_t count, std::size_t first, RetryOptions retry, std::uint32_t seed);

  struct Choice {
    std::size_t address = 0;
    Time not_before = {};
  };
  /// The one that may be tried soonest; of several, the next in turn.
  Choice choose(Time now) const;

  /// It could not be reached, broke, or does not want us. The next in turn comes first then.
  void failed(std::size_t address, Time now, std::optional<std::chrono::milliseconds> asked_for);
  void reached(std::size_t address);
  /// True if every address failed since it was reached last.
  bool nobody_in_reach() const;

 private:
  struct Entry {
    std::uint32_t failures = 0;  // since it was reached
    Time not_before = {};
  };
  RetryOptions retry_;
  std::minstd_rand random_;
  std::vector<Entry> entries_;
  std::size_t turn_;
};

}  // namespace segserve::client
