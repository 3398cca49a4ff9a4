// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>

#include "server/options/listen_address.hpp"

namespace segserve::server {

/// An address at which this process listens.
struct WatchedListener {
  ListenAddress address;
  int port = 0;  ///< that was bound; of no meaning for a unix socket
  /// The number of connections that were accepted so far; null if nobody counts them.
  std::function<std::uint64_t()> accepted;
};

}  // namespace segserve::server
