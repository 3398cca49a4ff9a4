// SPDX-License-Identifier: Apache-2.0
#include "tls/tls_reload.hpp"

#include "core/base/status_macros.hpp"

namespace segserve::tls {
namespace {

absl::StatusOr<std::shared_ptr<const TlsIdentity>> checked(const TlsFiles& files,
                                                           const absl::StatusOr<TlsContents>& contents) {
  RETURN_IF_ERROR(contents.status());
  ASSIGN_OR_RETURN(const TlsValidity validity, check_contents(files, *contents));
  return std::make_shared<const TlsIdentity>(TlsIdentity{*contents, validity});
}

}  // namespace

absl::StatusOr<TlsReload> TlsReload::load(TlsFiles files) {
  ASSIGN_OR_RETURN(auto identity, checked(files, read_files(files)));
  return TlsReload(std::move(files), std::move(identity));
}

std::optional<absl::Status> TlsReload::poll() {
  auto contents = read_files(files_);
  if (contents.ok() && *contents == identity_->contents) {
    suspect_.reset();
    return std::nullopt;
  }
  auto identity = checked(files_, contents);
  if (identity.ok()) {
    identity_ = *std::move(identity);
    suspect_.reset();
    return absl::OkStatus();
  }
  const bool is_known = suspect_ && (contents.ok() ? suspect_->contents.ok() && *suspect_->contents == *contents
                                                   : suspect_->contents.status() == contents.status());
  if (!is_known) {
    suspect_ = Suspect{std::move(contents)};
    return std::nullopt;
  }
  if (suspect_->was_reported) return std::nullopt;
  suspect_->was_reported = true;
  return identity.status();
}

}  // namespace segserve::tls
