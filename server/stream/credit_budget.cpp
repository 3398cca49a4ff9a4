// SPDX-License-Identifier: Apache-2.0
#include "server/stream/credit_budget.hpp"

#include <algorithm>
#include <utility>

namespace segserve::server {

CreditBudget::Reservation& CreditBudget::Reservation::operator=(Reservation&& other) noexcept {
  if (this != &other) {
    release();
    budget_ = std::exchange(other.budget_, nullptr);
    credit_ = other.credit_;
  }
  return *this;
}

void CreditBudget::Reservation::release() {
  if (!budget_) return;
  const MutexLock lock(budget_->mutex_);
  budget_->free_bytes_ += credit_.bytes;
  budget_ = nullptr;
}

std::optional<CreditBudget::Reservation> CreditBudget::reserve(const Credit& wanted) {
  Credit credit = limits_.most_per_stream;
  if (wanted.frames > 0) credit.frames = std::min(credit.frames, wanted.frames);
  credit.bytes = std::min(credit.bytes, wanted.bytes > 0 ? wanted.bytes : limits_.default_bytes_per_stream);

  const MutexLock lock(mutex_);
  const std::uint64_t least = std::max<std::uint64_t>(1, credit.bytes / 16);
  if (free_bytes_ < least) return std::nullopt;
  credit.bytes = std::min(credit.bytes, free_bytes_);
  free_bytes_ -= credit.bytes;
  return Reservation(*this, credit);
}

std::uint64_t CreditBudget::free_bytes() const {
  const MutexLock lock(mutex_);
  return free_bytes_;
}

}  // namespace segserve::server
