// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <list>
#include <map>
#include <memory>
#include <optional>
#include <utility>

#include "absl/base/thread_annotations.h"
#include "core/base/mutex.hpp"
#include "credentials/json_web_token.hpp"
#include "credentials/token_hash.hpp"

namespace segserve::server {

struct AccessFiles;

/// Remembers JWT that were verified, by their hashes, so that their signatures are checked once and not for every call.
/// Keeps a bounded number of them, those of the last use, and none from files that are not in use any more.
/// Thread-safe.
class VerifiedJwts {
 public:
  explicit VerifiedJwts(std::size_t most = 4096) : most_(most) {}

  /// Finds the claims of the token, if it was verified with these files.
  std::optional<credentials::JwtClaims> find(const credentials::TokenHash& hash,
                                             const std::shared_ptr<const AccessFiles>& files);
  void add(const credentials::TokenHash& hash, const std::shared_ptr<const AccessFiles>& files,
           credentials::JwtClaims claims);

 private:
  using Entry = std::pair<credentials::TokenHash, credentials::JwtClaims>;

  void forget_unless_of(const std::shared_ptr<const AccessFiles>& files) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  const std::size_t most_;
  Mutex mutex_;
  std::shared_ptr<const AccessFiles> files_ ABSL_GUARDED_BY(mutex_);
  std::list<Entry> entries_ ABSL_GUARDED_BY(mutex_);  // the last used first
  std::map<credentials::TokenHash, std::list<Entry>::iterator> places_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace segserve::server
