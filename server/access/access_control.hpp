// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/base/mutex.hpp"
#include "credentials/json_web_key.hpp"
#include "credentials/json_web_token.hpp"
#include "credentials/token_file.hpp"
#include "credentials/watched_file.hpp"
#include "server/access/access_grant.hpp"
#include "server/access/subject.hpp"
#include "server/access/verified_jwts.hpp"

namespace segserve::server {

/// Where the proofs come from that a server accepts. The flags of the program `segserve` have the same names.
struct AccessOptions {
  std::string tokens = {};    ///< a file of tokens and limits; empty: none
  std::string jwt_keys = {};  ///< a JSON Web Key Set; empty: JWT are not accepted
  std::string jwt_issuer = {}, jwt_audience = {};
};

/// The contents of the files at one time.
struct AccessFiles {
  credentials::TokenFile tokens;
  credentials::JsonWebKeys keys;
};

/// The proofs of identity that a call brings. The views must outlive the use.
struct PresentedProofs {
  std::vector<std::string_view> authorizations = {};  ///< the values of all `authorization` headers
  std::string certificate_name = {};                  ///< of the client's certificate, which TLS has verified; or empty
};

/// Decides who may call the server, as whom, and within which limits. Thread-safe.
///
/// A caller is the subject of the bearer token that the call has, or else of the client's certificate. Without either,
/// it is anonymous, which is refused if there are files of tokens or keys. The subject of a JWT is its issuer, a slash,
/// and its `sub`; that of a certificate is "cert:" and its name. So no two kinds of proof give the same name.
class AccessControl {
 public:
  using WallClock = std::function<credentials::WallTime()>;

  /// Reads the files. INVALID_ARGUMENT or NOT_FOUND names every fault of all of them.
  static absl::StatusOr<std::unique_ptr<AccessControl>> open(AccessOptions options,
                                                             WallClock now = std::chrono::system_clock::now);

  /// Returns the rights of the caller. UNAUTHENTICATED if the proof is missing, wrong, or over.
  absl::StatusOr<AccessGrant> admit(const PresentedProofs& presented);

  /// Looks for files that have changed, and uses them if they have no fault. Otherwise the old ones stay in use, and
  /// the faults go to the log once. That a file has no token any more is a fault, too. To be called about twice a
  /// second.
  void look_for_changes();

  struct Reloads {
    std::uint64_t done = 0, failed = 0;
  };
  /// The number of times that changed files were taken, and that they were not because of faults.
  Reloads reloads() const { return {reloads_done_, reloads_failed_}; }

  // These functions are for AccessGrant.
  std::shared_ptr<const AccessFiles> files() const;
  /// Whether these files still accept the proof of the subject, which others have accepted. Brings `not_after` up to
  /// date.
  static absl::Status check_anew(const AccessFiles& files, const std::string& subject, Proof& proof);
  absl::Status check_time(const Proof& proof) const;

 private:
  using Load = absl::Status (*)(const credentials::WatchedFile::Content&, const std::string& path, AccessFiles&);

  AccessControl(AccessOptions options, WallClock now);

  bool requires_proof() const { return !options_.tokens.empty() || !options_.jwt_keys.empty(); }
  absl::Status read_files() ABSL_LOCKS_EXCLUDED(watching_);
  void reload(credentials::WatchedFile& file, Load load) ABSL_EXCLUSIVE_LOCKS_REQUIRED(watching_);
  void use(AccessFiles files);
  absl::StatusOr<AccessGrant> admit_token(std::string_view token);
  absl::StatusOr<AccessGrant> admit_jwt(std::string_view token, const credentials::TokenHash& hash,
                                        const std::shared_ptr<const AccessFiles>& files);
  AccessGrant grant(const std::shared_ptr<const AccessFiles>& files, Proof proof, const std::string& name);

  const AccessOptions options_;
  const WallClock now_;
  VerifiedJwts verified_jwts_;
  std::atomic<std::uint64_t> reloads_done_{0}, reloads_failed_{0};

  mutable Mutex mutex_;
  std::shared_ptr<const AccessFiles> files_ ABSL_GUARDED_BY(mutex_);
  std::map<std::string, std::shared_ptr<Subject>> subjects_ ABSL_GUARDED_BY(mutex_);

  Mutex watching_;  // is held while files are read, and taken before `mutex_`
  credentials::WatchedFile token_file_ ABSL_GUARDED_BY(watching_);
  credentials::WatchedFile key_file_ ABSL_GUARDED_BY(watching_);
};

}  // namespace segserve::server
