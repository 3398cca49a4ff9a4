// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <optional>
#include <string>

#include "absl/status/status.h"
#include "client/tls/client_tls.hpp"
#include "client/tls/handshake_probe.hpp"

namespace segserve::client {

/// The time that the diagnosis of a failed handshake may take, also beyond the deadline of a call.
inline constexpr std::chrono::milliseconds kHandshakeProbeTime{1000};

/// Why a connection of gRPC to this address has failed, as far as it is a matter of TLS: gRPC 1.51 tells little of
/// that. It finds out by a handshake of its own. UNAUTHENTICATED, with a sentence that says what is wrong; OK if it
/// finds nothing wrong within `timeout`. `tls` is unset for a client that speaks plain text.
absl::Status find_handshake_fault(const std::string& address, const std::optional<ClientTls>& tls,
                                  std::chrono::milliseconds timeout);

/// Tells as find_handshake_fault does what was wrong with a handshake that was made with `server` at `now`.
absl::Status fault_of(const HandshakeReport& report, const std::string& address, const HostAndPort& server,
                      const std::optional<ClientTls>& tls, std::chrono::system_clock::time_point now);

/// True for the errors of these functions, which another server may not have, and another try at the same one has
/// again.
bool is_handshake_fault(const absl::Status& status);

}  // namespace segserve::client
