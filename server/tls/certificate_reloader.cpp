// SPDX-License-Identifier: Apache-2.0
#include "server/tls/certificate_reloader.hpp"

#include <utility>

#include "core/base/status_macros.hpp"
#include "core/base/status_text.hpp"
#include "server/frames/catch_exceptions.hpp"
#include "spdlog/spdlog.h"

namespace segserve::server {

absl::StatusOr<std::shared_ptr<CertificateReloader>> CertificateReloader::start(tls::TlsFiles files,
                                                                                std::chrono::milliseconds interval) {
  ASSIGN_OR_RETURN(tls::TlsReload reload, tls::TlsReload::load(std::move(files)));
  return std::make_shared<CertificateReloader>(std::move(reload), interval);
}

CertificateReloader::CertificateReloader(tls::TlsReload reload, std::chrono::milliseconds interval)
    : reload_(std::move(reload)),
      certificate_warning_("the certificate of " + reload_.files().certificate),
      client_ca_warning_("a certificate of " + reload_.files().authorities),
      identity_(reload_.identity()),
      ticker_(interval, [this] {
        catch_exceptions("read the files of TLS again", [this] {
          take_new_files();
          warn_of_ends();
          return absl::OkStatus();
        }).IgnoreError();  // it is in the log
        return true;
      }) {}

std::shared_ptr<const tls::TlsIdentity> CertificateReloader::identity() const {
  const MutexLock lock(mutex_);
  return identity_;
}

TlsStatus CertificateReloader::status() const {
  const MutexLock lock(mutex_);
  TlsStatus status{.certificate_end = identity_->validity.certificate->end,
                   .client_ca_end = std::nullopt,
                   .reloads = reloads_,
                   .failed_reloads = failed_reloads_};
  if (identity_->validity.authorities) status.client_ca_end = identity_->validity.authorities->end;
  return status;
}

void CertificateReloader::take_new_files() {
  const std::optional<absl::Status> news = reload_.poll();
  if (!news) return;
  const MutexLock lock(mutex_);
  ++(news->ok() ? reloads_ : failed_reloads_);
  identity_ = reload_.identity();
  if (news->ok()) {
    spdlog::info("new TLS certificates are in use; they are valid until {}",
                 tls::text_of(identity_->validity.certificate->end));
  } else {
    spdlog::error("new TLS certificates are refused, and the old ones stay in use: {}", message_of(*news));
  }
}

void CertificateReloader::warn_of_ends() {
  const auto now = std::chrono::system_clock::now();
  const tls::TlsValidity& validity = reload_.identity()->validity;
  const auto certificate = certificate_warning_.due(*validity.certificate, now);
  if (certificate) spdlog::warn("{}", *certificate);
  if (!validity.authorities) return;
  const auto client_ca = client_ca_warning_.due(*validity.authorities, now);
  if (client_ca) spdlog::warn("{}", *client_ca);
}

}  // namespace segserve::server
