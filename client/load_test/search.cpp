// SPDX-License-Identifier: Apache-2.0
#include "client/load_test/search.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "core/base/status_macros.hpp"

namespace segserve::bench {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kLowestShare = 1.0 / 4096;  // of the first rate, below which none is tried
constexpr std::ptrdiff_t kMajority = 2;      // of up to three tries

class Search {
 public:
  Search(const SearchOptions& options, const std::function<absl::StatusOr<bool>(double)>& attempt)
      : options_(options), attempt_(attempt) {}

  absl::StatusOr<Capacity> run() {
    RETURN_IF_ERROR(try_once(std::min(options_.first, options_.highest)));
    while (may_try()) {
      update();
      const double next = next_rate();
      if (next == 0) break;
      RETURN_IF_ERROR(try_once(next));
    }
    update();
    return found_;
  }

 private:
  bool may_try() const { return found_.tries.size() < options_.most_tries; }

  absl::Status try_once(double rate) {
    ASSIGN_OR_RETURN(const bool met, attempt_(rate));
    found_.tries.push_back({rate, met});
    return absl::OkStatus();
  }

  std::ptrdiff_t count(double rate, bool met) const {
    return std::ranges::count_if(found_.tries,
                                 [&](const SearchTry& each) { return each.rate == rate && each.met == met; });
  }
  bool is_met(double rate) const { return count(rate, true) > count(rate, false); }
  bool is_sure(double rate) const { return std::max(count(rate, true), count(rate, false)) >= kMajority; }

  /// The lowest rate that missed, and the highest one below it that did not. A rate whose tries are even missed.
  void update() {
    found_.high = kInfinity;
    found_.low = 0;
    for (const SearchTry& each : found_.tries) {
      if (!is_met(each.rate)) found_.high = std::min(found_.high, each.rate);
    }
    for (const SearchTry& each : found_.tries) {
      if (is_met(each.rate) && each.rate < found_.high) found_.low = std::max(found_.low, each.rate);
    }
  }

  /// 0: the search is over.
  double next_rate() const {
    const double lowest = options_.first * kLowestShare;
    if (found_.high == kInfinity) return found_.low < options_.highest ? std::min(2 * found_.low, options_.highest) : 0;
    if (found_.low == 0) return found_.high / 2 >= lowest ? found_.high / 2 : 0;
    // The ends of a wide interval are tried again only if they are still the ends when it has become narrow.
    if (found_.high > found_.low * (1 + options_.precision)) return (found_.low + found_.high) / 2;
    if (!is_sure(found_.low)) return found_.low;
    return is_sure(found_.high) ? 0 : found_.high;
  }

  const SearchOptions& options_;
  const std::function<absl::StatusOr<bool>(double)>& attempt_;
  Capacity found_;
};

}  // namespace

absl::StatusOr<Capacity> find_capacity(const SearchOptions& options,
                                       const std::function<absl::StatusOr<bool>(double rate)>& attempt) {
  return Search(options, attempt).run();
}

}  // namespace segserve::bench
