// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <string>

#include "absl/status/statusor.h"
#include "credentials/json_web_key.hpp"
#include "credentials/token_file.hpp"
#include "credentials/token_hash.hpp"
#include "server/access/subject.hpp"

namespace segserve::server {

class AccessControl;
struct AccessFiles;

/// The proof by which a caller has shown that it is a subject.
struct Proof {
  enum class Kind : std::uint8_t { kNone, kToken, kJwt, kCertificate } kind = Kind::kNone;
  credentials::TokenHash hash = {};                           ///< of a token
  std::optional<credentials::JsonWebKey> key = std::nullopt;  ///< that has signed a JWT
  std::optional<credentials::WallTime> not_after = std::nullopt;
};

/// The rights of a call or a stream. A default one is that of an anonymous caller, who may do everything. One thread at
/// a time may use it; the AccessControl that made it must outlive it.
class AccessGrant {
 public:
  AccessGrant() = default;
  AccessGrant(const AccessControl& control, std::shared_ptr<const AccessFiles> checked_with, Proof proof,
              std::shared_ptr<Subject> subject);

  /// Empty if the caller is anonymous.
  const std::string& subject() const;

  /// OK as long as the proof holds; UNAUTHENTICATED once its token has expired or was withdrawn, or the key that signed
  /// it was. Cheap enough for every frame.
  absl::Status check();

  /// Takes a frame: see Subject::admit.
  absl::StatusOr<QuotaLease> admit(std::uint64_t points, std::uint64_t bytes) const;
  /// The priority that a frame gets which asks for this one.
  std::int32_t priority(std::int32_t wanted) const;
  /// The most bytes that can be in flight.
  std::uint64_t most_bytes() const;

 private:
  const AccessControl* control_ = nullptr;
  std::shared_ptr<const AccessFiles> checked_with_;
  Proof proof_;
  std::shared_ptr<Subject> subject_;
};

}  // namespace segserve::server
