// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <string>
#include <utility>

#include "absl/status/statusor.h"
#include "client/tls/client_tls.hpp"
#include "segserve/client/tls_options.hpp"
#include "tls/tls_reload.hpp"

namespace segserve::client {

/// Gives connections the latest contents of the files of TLS. Not for several threads at a time.
class TlsSource {
 public:
  /// INVALID_ARGUMENT names what is wrong with the options, or the file and its fault.
  static absl::StatusOr<TlsSource> load(const TlsOptions& options);

  /// Reads the files again, but not within a second of the last time. True if what they hold is new. New files that are
  /// wrong change nothing.
  bool refresh(std::chrono::steady_clock::time_point now);
  ClientTls current() const;

 private:
  TlsSource(tls::TlsReload reload, std::string server_name)
      : reload_(std::move(reload)), server_name_(std::move(server_name)) {}

  tls::TlsReload reload_;
  std::string server_name_;
  std::chrono::steady_clock::time_point read_at_ = std::chrono::steady_clock::now();
};

}  // namespace segserve::client
