// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "credentials/subject_limits.hpp"
#include "credentials/token_hash.hpp"

namespace segserve::credentials {

using WallTime = std::chrono::system_clock::time_point;

constexpr std::size_t kMostTokenFileBytes = std::size_t{4} << 20U;

/// The content of a file of tokens. It is a TOML file that holds no secrets:
///
///     [default]                      # limits of subjects that have none of their own
///     frames_per_second = 30
///
///     [subject.robot-7]              # limits of a subject, also of one that JWT or a certificate names
///     points_per_second = 5_000_000
///     bytes_in_flight = 67_108_864
///     highest_priority = 0
///
///     [[token]]                      # a subject may have several
///     subject = "robot-7"
///     sha256 = "..."                 # of the token, 64 hexadecimal digits
///     not_after = 2027-01-01T00:00:00Z
struct TokenFile {
  struct Token {
    TokenHash hash;
    std::string subject;
    std::optional<WallTime> not_after;  ///< from then on it is no proof any more; unset: never
  };

  std::vector<Token> tokens;
  SubjectLimits default_limits;
  std::map<std::string, SubjectLimits, std::less<>> subject_limits;

  /// The token with this hash, or null. Compares with all tokens, in a time that does not depend on the hash.
  const Token* find(const TokenHash& hash) const;
  /// The subject's own limits, and the defaults for those that it has not.
  SubjectLimits limits_of(std::string_view subject) const;
};

/// Whether a subject of a token may have this name: letters, digits and "._-@", at most 64. So it is never that of a
/// JWT, which has a slash, or of a certificate, which has a colon.
bool is_subject_name(std::string_view name);

/// INVALID_ARGUMENT names every fault with its line, e.g. "tokens.toml:7: there is no 'frames'". A file that is no
/// TOML, or has letters beyond ASCII, has one fault. `name` stands for the file in messages.
absl::StatusOr<TokenFile> parse_token_file(std::string_view text, std::string_view name);

}  // namespace segserve::credentials
