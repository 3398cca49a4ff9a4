// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <utility>

#include "tls/certificates.hpp"

namespace segserve::server {

/// Warns of a certificate that ends within 30 days (or, if that is less, the last third of its life), has ended, or is
/// not valid yet: when that is first found, and again each day. Knows no clock.
class EndWarning {
 public:
  /// `subject` begins the warnings, e.g. "the certificate of server.crt".
  explicit EndWarning(std::string subject) : subject_(std::move(subject)) {}

  /// The warning that is due at `now`, if any.
  std::optional<std::string> due(const tls::Validity& validity, std::chrono::system_clock::time_point now);

 private:
  enum class State { kValid, kNotYet, kEndsSoon, kEnded };

  std::string subject_;
  State state_ = State::kValid;                       // at the last warning
  std::chrono::sys_seconds end_;                      // of the certificate that it was about
  std::chrono::system_clock::time_point not_before_;  // when to repeat it
};

}  // namespace segserve::server
