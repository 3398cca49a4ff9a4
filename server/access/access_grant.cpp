// SPDX-License-Identifier: Apache-2.0
#include "server/access/access_grant.hpp"

#include <algorithm>
#include <chrono>
#include <utility>

#include "core/base/status_macros.hpp"
#include "server/access/access_control.hpp"

namespace segserve::server {

AccessGrant::AccessGrant(const AccessControl& control, std::shared_ptr<const AccessFiles> checked_with, Proof proof,
                         std::shared_ptr<Subject> subject)
    : control_(&control),
      checked_with_(std::move(checked_with)),
      proof_(std::move(proof)),
      subject_(std::move(subject)) {}

const std::string& AccessGrant::subject() const {
  static const std::string anonymous;
  return subject_ ? subject_->name() : anonymous;
}

absl::Status AccessGrant::check() {
  if (control_ == nullptr) return absl::OkStatus();
  if (std::shared_ptr<const AccessFiles> files = control_->files(); files != checked_with_) {
    RETURN_IF_ERROR(AccessControl::check_anew(*files, subject(), proof_));
    checked_with_ = std::move(files);
  }
  return control_->check_time(proof_);
}

absl::StatusOr<QuotaLease> AccessGrant::admit(std::uint64_t points, std::uint64_t bytes) const {
  if (!subject_) return QuotaLease();
  return subject_->admit(points, bytes, std::chrono::steady_clock::now());
}

std::int32_t AccessGrant::priority(std::int32_t wanted) const {
  if (!subject_) return wanted;
  return std::min(wanted, subject_->limits().highest_priority.value_or(wanted));
}

std::uint64_t AccessGrant::most_bytes() const {
  constexpr std::uint64_t kAny = std::numeric_limits<std::uint64_t>::max();
  return subject_ ? subject_->limits().bytes_in_flight.value_or(kAny) : kAny;
}

}  // namespace segserve::server
