// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/status.h"

namespace segserve::client {

/// Names one server of a client; never used twice.
using ServerId = std::uint64_t;

/// A process to send frames to, or what gRPC takes for one.
struct Server {
  ServerId id = 0;
  std::string target = {};     ///< what gRPC connects to
  std::string authority = {};  ///< HOST:PORT as the user gave it, for TLS; empty: gRPC takes it from `target`
  std::string address = {};    ///< for reports and messages
};

/// The servers that the addresses of a client stand for at one time.
struct ServerList {
  std::vector<Server> servers;
  absl::Status trouble;  ///< why a name without servers has none; OK if there is none, or it is being looked up
};

}  // namespace segserve::client
