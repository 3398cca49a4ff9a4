// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>

#include "absl/base/thread_annotations.h"
#include "absl/status/statusor.h"
#include "core/base/mutex.hpp"
#include "server/scheduling/ticker.hpp"
#include "server/tls/end_warning.hpp"
#include "tls/tls_reload.hpp"

namespace segserve::server {

/// The facts about the certificates in use that an operator wants to know.
struct TlsStatus {
  std::chrono::sys_seconds certificate_end;               ///< the first end of the certificate and its chain
  std::optional<std::chrono::sys_seconds> client_ca_end;  ///< the first end of those who sign clients' certificates
  std::uint64_t reloads = 0;                              ///< new sets of files that were taken
  std::uint64_t failed_reloads = 0;                       ///< new sets of files that were wrong
};

/// Keeps the certificates of the server, and takes new ones within a few seconds when their files change. It logs what
/// it takes and what it refuses, and warns of certificates that end soon. Any number of threads may use it.
class CertificateReloader {
 public:
  /// INVALID_ARGUMENT names the file and its fault.
  static absl::StatusOr<std::shared_ptr<CertificateReloader>> start(
      tls::TlsFiles files, std::chrono::milliseconds interval = std::chrono::seconds(1));

  /// Uses files that were found right.
  CertificateReloader(tls::TlsReload reload, std::chrono::milliseconds interval);

  /// The set that new connections shall use. Never null; a new set is a new object.
  std::shared_ptr<const tls::TlsIdentity> identity() const ABSL_LOCKS_EXCLUDED(mutex_);
  TlsStatus status() const ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  // These are the ticker's.
  void take_new_files() ABSL_LOCKS_EXCLUDED(mutex_);
  void warn_of_ends();

  tls::TlsReload reload_;  // this and the warnings are the ticker's
  EndWarning certificate_warning_;
  EndWarning client_ca_warning_;

  mutable Mutex mutex_;
  std::shared_ptr<const tls::TlsIdentity> identity_ ABSL_GUARDED_BY(mutex_);
  std::uint64_t reloads_ ABSL_GUARDED_BY(mutex_) = 0;
  std::uint64_t failed_reloads_ ABSL_GUARDED_BY(mutex_) = 0;
  Ticker ticker_;  // is destroyed first
};

}  // namespace segserve::server
