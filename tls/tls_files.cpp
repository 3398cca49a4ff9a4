// SPDX-License-Identifier: Apache-2.0
#include "tls/tls_files.hpp"

#include <cstddef>

#include "core/base/regular_file.hpp"
#include "core/base/status_macros.hpp"
#include "core/base/status_text.hpp"
#include "fmt/format.h"

namespace segserve::tls {
namespace {

constexpr std::size_t kMostBytes = std::size_t{4} << 20U;

/// No path stands for no content.
absl::StatusOr<std::string> read_file(const std::string& path) {
  if (path.empty()) return std::string();
  auto content = read_regular_file(path, kMostBytes);
  if (!content.ok()) return absl::InvalidArgumentError(message_of(content.status()));
  return content;
}

}  // namespace

absl::StatusOr<TlsContents> read_files(const TlsFiles& files) {
  TlsContents contents;
  ASSIGN_OR_RETURN(contents.certificate, read_file(files.certificate));
  ASSIGN_OR_RETURN(contents.key, read_file(files.key));
  ASSIGN_OR_RETURN(contents.authorities, read_file(files.authorities));
  return contents;
}

absl::StatusOr<TlsValidity> check_contents(const TlsFiles& files, const TlsContents& contents) {
  TlsValidity validity;
  if (!files.certificate.empty()) {
    const auto chain = parse_certificates(contents.certificate);
    if (!chain.ok()) return with_prefix(files.certificate, chain.status());
    const auto key = parse_key(contents.key);
    if (!key.ok()) return with_prefix(files.key, key.status());
    const absl::Status pair = check_pair(*chain, **key);
    if (!pair.ok()) return with_prefix(fmt::format("{} and {}", files.certificate, files.key), pair);
    validity.certificate = validity_of(*chain);
  }
  if (!files.authorities.empty()) {
    const auto authorities = parse_certificates(contents.authorities);
    if (!authorities.ok()) return with_prefix(files.authorities, authorities.status());
    validity.authorities = validity_of(*authorities);
  }
  return validity;
}

}  // namespace segserve::tls
