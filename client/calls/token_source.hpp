// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/base/mutex.hpp"
#include "segserve/client/client.hpp"

namespace segserve::client {

/// The bearer token of a client, and the file that it comes from. Thread-safe. No message holds the token.
class TokenSource {
 public:
  /// The token of the options, which may have none. INVALID_ARGUMENT if they have both a token and a file, or if it is
  /// no token; NOT_FOUND if the file cannot be read.
  static absl::StatusOr<std::shared_ptr<TokenSource>> make(const ClientOptions& options);

  /// The token, empty if there is none. A file is read anew, so that a new token is in use at once; if it cannot be
  /// read any more, or holds no token, the last one stays.
  std::string token();

 private:
  TokenSource(std::string token, std::string file) : file_(std::move(file)), token_(std::move(token)) {}

  const std::string file_;  // empty: the token never changes
  Mutex mutex_;
  std::string token_ ABSL_GUARDED_BY(mutex_);
};

/// OK if the token may be sent to the address as plain text, because it stays on this machine. INVALID_ARGUMENT
/// otherwise: whoever listens in could use the token.
absl::Status check_plain_text_token(std::string_view address);

}  // namespace segserve::client
