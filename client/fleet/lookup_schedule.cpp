// SPDX-License-Identifier: Apache-2.0
#include "client/fleet/lookup_schedule.hpp"

#include <chrono>

namespace segserve::client {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds kUsualWait{10'000}, kShortWait{2000}, kHurry{10'000};

}  // namespace

std::optional<Time> LookupSchedule::due() const {
  if (!last_) return std::nullopt;
  const bool in_hurry = hurry_until_ && *last_ < *hurry_until_;
  const auto wait = std::chrono::duration<double, std::milli>(in_hurry ? kShortWait : kUsualWait) * share_;
  return *last_ + std::chrono::duration_cast<milliseconds>(wait);
}

void LookupSchedule::on_answer(bool is_news, Time now) {
  last_ = now;
  share_ = std::uniform_real_distribution<double>(0.8, 1.0)(random_);
  if (is_news) hurry_until_ = now + kHurry;
}

void LookupSchedule::on_trouble(Time now) { hurry_until_ = now + kHurry; }

}  // namespace segserve::client
