// SPDX-License-Identifier: Apache-2.0
#include "server/tls/end_warning.hpp"

#include <algorithm>

#include "fmt/format.h"

namespace segserve::server {
namespace {

using std::chrono::days, std::chrono::hours;

constexpr days kRepetition{1};

/// How long before its end a certificate is about to end: 30 days, but no more than a third of its life, so that those
/// that are renewed each day are not always about to end.
std::chrono::seconds soon(const tls::Validity& validity) {
  return std::min<std::chrono::seconds>(days(30), (validity.end - validity.begin) / 3);
}

std::string text_of(std::chrono::system_clock::duration left) {
  constexpr days kFewDays{2};
  if (left >= kFewDays) return fmt::format("{} days", std::chrono::floor<days>(left).count());
  return fmt::format("{} hours", std::chrono::floor<hours>(left).count());
}

}  // namespace

std::optional<std::string> EndWarning::due(const tls::Validity& validity, std::chrono::system_clock::time_point now) {
  const State state = now < validity.begin                   ? State::kNotYet
                      : now >= validity.end                  ? State::kEnded
                      : now + soon(validity) >= validity.end ? State::kEndsSoon
                                                             : State::kValid;
  const bool is_news = state != state_ || validity.end != end_ || now >= not_before_;
  if (!is_news) return std::nullopt;
  state_ = state;
  end_ = validity.end;
  not_before_ = now + kRepetition;
  switch (state) {
    case State::kNotYet:
      return fmt::format("{} is not valid before {}: connections fail", subject_, tls::text_of(validity.begin));
    case State::kEndsSoon:
      return fmt::format("{} ends in {}, on {}", subject_, text_of(validity.end - now), tls::text_of(validity.end));
    case State::kEnded:
      return fmt::format("{} has ended on {}: connections fail", subject_, tls::text_of(validity.end));
    case State::kValid:
      break;
  }
  return std::nullopt;
}

}  // namespace segserve::server
