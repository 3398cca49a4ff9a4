#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string>

#include "segserve/options.hpp"

namespace segserve::server {

/// How a server runs. The flags of the binary `segserve` have the same names.
struct ServerOptions {
  /// HOST:PORT, [IPv6]:PORT or unix:PATH; port 0 picks a free one.
  std::string listen = "127.0.0.1:50051";
  /// Plain text on an address that other machines can reach is refused unless this says so.
  bool insecure_beyond_loopback = false;

  /// Calls computed at the same time; 0: one per CPU.
  std::size_t workers = 0;
  /// Most threads within one call.
  std::uint32_t threads = 1;
  /// Calls that may wait for a worker.
  std::size_t queue = 64;
  /// Bytes of requests, waiting or computed, over all clients.
  std::uint64_t queue_bytes = std::uint64_t{512} << 20U;
  /// Points of clouds, waiting or computed, over all clients.
  std::uint64_t queue_points = 50'000'000;

  /// Credit of one stream: frames and bytes of payload that it may have on their way. A cloud of more bytes cannot be
  /// sent.
  std::uint32_t stream_frames = 8;
  std::uint64_t stream_bytes = std::uint64_t{512} << 20U;
  /// Bytes of credit of all streams together; a stream gets 32 MiB unless it asks for more.
  std::uint64_t all_streams_bytes = std::uint64_t{2} << 30U;

  /// Points of one cloud.
  std::uint64_t max_points = 16'000'000;
  /// Bytes of one cloud after decompression.
  std::uint64_t max_decoded_bytes = std::uint64_t{512} << 20U;
  /// Accept Draco payloads. Its library has known faults with hostile bytes.
  bool enable_draco = false;

  /// Time for the calls in flight when the server stops; then they are cancelled.
  std::chrono::milliseconds grace_period{20'000};

  /// A stopping server answers new calls with UNAVAILABLE (DRAINING) for at least this long before it closes its
  /// connections (at most the grace period), so that calls on their way get an answer that says what to do.
  std::chrono::milliseconds drain_delay{200};

  /// The segmentation of a call that sets no options.
  Options defaults;
};

}  // namespace segserve::server
