// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "server/memory/memory_ledger.hpp"

namespace segserve::server {

/// Whose part of the workers and of the memory a call gets.
struct ClientShare {
  std::string client;  ///< JobInfo::client
  std::string flow;    ///< JobInfo::flow
  MemoryOwner owner;
};

/// The share of a call from `peer` (gRPC's name of the other end). Subjects have equal parts of the server, and within
/// a subject its streams and connections. `part` is the stream, or the connection of a unary call. A caller without a
/// subject is its stream or connection; its memory is that of its address, because many programs share one, and names
/// can be made up.
ClientShare share_of(const std::string& subject, const std::string& peer, const std::string& part);

}  // namespace segserve::server
