// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "tls/tls_files.hpp"

namespace segserve::tls {

/// The contents of the files when they were last found right.
struct TlsIdentity {
  TlsContents contents;
  TlsValidity validity;
};

/// Reads files again, and keeps the last set of them that was right. One thread may use it at a time.
class TlsReload {
 public:
  /// INVALID_ARGUMENT names the file and its fault.
  static absl::StatusOr<TlsReload> load(TlsFiles files);

  const TlsFiles& files() const { return files_; }
  /// Never null. It stays as it is; a new set is a new object.
  const std::shared_ptr<const TlsIdentity>& identity() const { return identity_; }

  /// Reads the files. Returns OK if they have changed and their new set is in use from now on, and an error, once, if
  /// they are wrong. Nothing if there is no news. A set is called wrong when two calls have found it so, because
  /// whoever renews a certificate and its key may write one after the other.
  std::optional<absl::Status> poll();

 private:
  TlsReload(TlsFiles files, std::shared_ptr<const TlsIdentity> identity)
      : files_(std::move(files)), identity_(std::move(identity)) {}

  TlsFiles files_;
  std::shared_ptr<const TlsIdentity> identity_;
  struct Suspect {
    absl::StatusOr<TlsContents> contents;
    bool was_reported = false;
  };
  std::optional<Suspect> suspect_;  // the set that was found wrong by the last call
};

}  // namespace segserve::tls
