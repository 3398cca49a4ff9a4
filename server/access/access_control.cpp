// SPDX-License-Identifier: Apache-2.0
#include "server/access/access_control.hpp"

#include <algorithm>
#include <utility>

#include "absl/strings/match.h"
#include "core/base/status_macros.hpp"
#include "core/base/status_text.hpp"
#include "server/access/access_refusals.hpp"
#include "spdlog/spdlog.h"

namespace segserve::server {
namespace {

using credentials::WatchedFile;

/// The token of "Bearer TOKEN"; empty if the header is of another kind.
std::string_view bearer_token(std::string_view authorization) {
  constexpr std::string_view kScheme = "bearer ";
  const absl::string_view header(authorization.data(), authorization.size());
  if (!absl::StartsWithIgnoreCase(header, {kScheme.data(), kScheme.size()})) return {};
  authorization.remove_prefix(kScheme.size());
  return authorization.substr(std::min(authorization.size(), authorization.find_first_not_of(' ')));
}

/// `files` has what the file said before. A file that has lost all tokens is mostly one that was not written to its
/// end, as on a full disk, and would lock out everybody.
absl::Status load_tokens(const WatchedFile::Content& content, const std::string& path, AccessFiles& files) {
  RETURN_IF_ERROR(content.status());
  ASSIGN_OR_RETURN(credentials::TokenFile tokens, credentials::parse_token_file(*content, path));
  if (tokens.tokens.empty() && !files.tokens.tokens.empty()) {
    return absl::InvalidArgumentError(
        "the file has no token any more; to withdraw the last one, give it a not_after in the past");
  }
  files.tokens = std::move(tokens);
  return absl::OkStatus();
}

absl::Status load_keys(const WatchedFile::Content& content, const std::string& path, AccessFiles& files) {
  RETURN_IF_ERROR(content.status());
  ASSIGN_OR_RETURN(files.keys, credentials::parse_json_web_keys(*content, path));
  return absl::OkStatus();
}

/// The faults of both, with the code of the first.
absl::Status joined(const absl::Status& first, const absl::Status& second) {
  if (first.ok() || second.ok()) return first.ok() ? second : first;
  return {first.code(), message_of(first) + "; " + message_of(second)};
}

}  // namespace

AccessControl::AccessControl(AccessOptions options, WallClock now)
    : options_(std::move(options)),
      now_(std::move(now)),
      files_(std::make_shared<const AccessFiles>()),
      token_file_(options_.tokens, credentials::kMostTokenFileBytes),
      key_file_(options_.jwt_keys, credentials::kMostKeyFileBytes) {}

absl::StatusOr<std::unique_ptr<AccessControl>> AccessControl::open(AccessOptions options, WallClock now) {
  std::unique_ptr<AccessControl> control(new AccessControl(std::move(options), std::move(now)));
  RETURN_IF_ERROR(control->read_files());
  return control;
}

absl::Status AccessControl::read_files() {
  const MutexLock lock(watching_);
  AccessFiles files;
  absl::Status tokens, keys;
  if (!options_.tokens.empty()) tokens = load_tokens(token_file_.read(), options_.tokens, files);
  if (!options_.jwt_keys.empty()) keys = load_keys(key_file_.read(), options_.jwt_keys, files);
  RETURN_IF_ERROR(joined(tokens, keys));
  if (options_.jwt_keys.empty() && !options_.tokens.empty() && files.tokens.tokens.empty()) {
    spdlog::warn("{} has no token, so that nobody may call", options_.tokens);
  }
  use(std::move(files));
  return absl::OkStatus();
}

void AccessControl::look_for_changes() {
  {
    const MutexLock lock(watching_);
    reload(token_file_, load_tokens);
    reload(key_file_, load_keys);
  }
  const auto now = std::chrono::steady_clock::now();
  const MutexLock lock(mutex_);
  std::erase_if(subjects_,
                [now](const auto& entry) { return entry.second.use_count() == 1 && entry.second->is_at_rest(now); });
}

void AccessControl::reload(WatchedFile& file, Load load) {
  if (file.path().empty()) return;
  const std::optional<WatchedFile::Content> content = file.changed();
  if (!content) return;
  AccessFiles changed = *files();
  if (const absl::Status status = load(*content, file.path(), changed); !status.ok()) {
    ++reloads_failed_;
    spdlog::error("what {} said before stays in use, because it has faults now: {}", file.path(), message_of(status));
    return;
  }
  use(std::move(changed));
  ++reloads_done_;
  spdlog::info("{} has changed, and is in use", file.path());
}

void AccessControl::use(AccessFiles files) {
  const auto now = std::chrono::steady_clock::now();
  const MutexLock lock(mutex_);
  files_ = std::make_shared<const AccessFiles>(std::move(files));
  for (const auto& [name, subject] : subjects_) subject->set_limits(files_->tokens.limits_of(name), now);
}

absl::StatusOr<AccessGrant> AccessControl::admit(const PresentedProofs& presented) {
  if (requires_proof() && !presented.authorizations.empty()) {
    const std::string_view token = bearer_token(presented.authorizations.front());
    if (presented.authorizations.size() > 1 || token.empty()) return token_invalid();
    return admit_token(token);
  }
  if (!presented.certificate_name.empty()) {
    return grant(files(), {.kind = Proof::Kind::kCertificate}, "cert:" + presented.certificate_name);
  }
  if (requires_proof()) return token_missing();
  return AccessGrant();
}

absl::StatusOr<AccessGrant> AccessControl::admit_token(std::string_view token) {
  const std::shared_ptr<const AccessFiles> files = this->files();
  const credentials::TokenHash hash = credentials::hash_of(token);
  if (const auto* found = files->tokens.find(hash)) {
    Proof proof{.kind = Proof::Kind::kToken, .hash = hash, .not_after = found->not_after};
    RETURN_IF_ERROR(check_time(proof));
    return grant(files, std::move(proof), found->subject);
  }
  if (files->keys.empty() || !credentials::looks_like_jwt(token)) return token_invalid();
  return admit_jwt(token, hash, files);
}

absl::StatusOr<AccessGrant> AccessControl::admit_jwt(std::string_view token, const credentials::TokenHash& hash,
                                                     const std::shared_ptr<const AccessFiles>& files) {
  std::optional<credentials::JwtClaims> claims = verified_jwts_.find(hash, files);
  if (!claims) {
    const credentials::JwtPolicy policy{options_.jwt_issuer, options_.jwt_audience};
    auto verified = credentials::verify_jwt(token, files->keys, policy, now_());
    if (!verified.ok()) {
      spdlog::debug("a token was refused: {}", message_of(verified.status()));
      return token_invalid();
    }
    claims = *std::move(verified);
    verified_jwts_.add(hash, files, *claims);
  }
  Proof proof{.kind = Proof::Kind::kJwt, .key = claims->key, .not_after = claims->not_after};
  RETURN_IF_ERROR(check_time(proof));
  return grant(files, std::move(proof), options_.jwt_issuer + "/" + claims->subject);
}

AccessGrant AccessControl::grant(const std::shared_ptr<const AccessFiles>& files, Proof proof,
                                 const std::string& name) {
  const MutexLock lock(mutex_);
  std::shared_ptr<Subject>& subject = subjects_[name];
  if (!subject) {
    // Files that have just changed have told the subjects that were there their limits.
    subject = std::make_shared<Subject>(name, files_->tokens.limits_of(name), std::chrono::steady_clock::now());
  }
  return {*this, files, std::move(proof), subject};
}

std::shared_ptr<const AccessFiles> AccessControl::files() const {
  const MutexLock lock(mutex_);
  return files_;
}

absl::Status AccessControl::check_anew(const AccessFiles& files, const std::string& subject, Proof& proof) {
  if (proof.kind == Proof::Kind::kToken) {
    const auto* token = files.tokens.find(proof.hash);
    if (token == nullptr || token->subject != subject) return token_invalid();
    proof.not_after = token->not_after;
  }
  const bool lost_its_key =
      proof.kind == Proof::Kind::kJwt && std::ranges::find(files.keys, *proof.key) == files.keys.end();
  return lost_its_key ? token_invalid() : absl::OkStatus();
}

absl::Status AccessControl::check_time(const Proof& proof) const {
  return proof.not_after && now_() >= *proof.not_after ? token_expired() : absl::OkStatus();
}

}  // namespace segserve::server
