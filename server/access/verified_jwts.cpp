// SPDX-License-Identifier: Apache-2.0
#include "server/access/verified_jwts.hpp"

namespace segserve::server {

std::optional<credentials::JwtClaims> VerifiedJwts::find(const credentials::TokenHash& hash,
                                                         const std::shared_ptr<const AccessFiles>& files) {
  const MutexLock lock(mutex_);
  forget_unless_of(files);
  const auto place = places_.find(hash);
  if (place == places_.end()) return std::nullopt;
  entries_.splice(entries_.begin(), entries_, place->second);
  return entries_.front().second;
}

void VerifiedJwts::add(const credentials::TokenHash& hash, const std::shared_ptr<const AccessFiles>& files,
                       credentials::JwtClaims claims) {
  const MutexLock lock(mutex_);
  forget_unless_of(files);
  if (places_.contains(hash)) return;
  entries_.emplace_front(hash, std::move(claims));
  places_[hash] = entries_.begin();
  if (entries_.size() <= most_) return;
  places_.erase(entries_.back().first);
  entries_.pop_back();
}

void VerifiedJwts::forget_unless_of(const std::shared_ptr<const AccessFiles>& files) {
  if (files_ == files) return;
  places_.clear();
  entries_.clear();
  files_ = files;
}

}  // namespace segserve::server
