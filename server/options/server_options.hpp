// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "segserve/options.hpp"

namespace segserve::server {

/// How a server runs. The flags of the program `segserve` have the same names.
struct ServerOptions {
  /// HOST:PORT, [IPv6]:PORT or unix:PATH; port 0 picks a free one.
  std::string listen = "127.0.0.1:50051";
  /// Plain text on an address that other machines can reach is refused unless this is set.
  bool insecure_beyond_loopback = false;

  /// Frames that are computed at the same time; 0: one per CPU.
  std::size_t workers = 0;
  /// Most threads within one frame.
  std::uint32_t threads = 1;
  /// Frames that may wait for a worker.
  std::size_t queue = 64;
  /// Bytes of all requests that wait or are computed, over all clients.
  std::uint64_t queue_bytes = std::uint64_t{512} << 20U;
  /// Points of all clouds that wait or are computed, over all clients.
  std::uint64_t queue_points = 50'000'000;

  /// Credit of one stream: frames, and bytes of payload, that it may have under way. A cloud of more bytes cannot be
  /// sent. A stream gets 32 MiB unless it asks for more.
  std::uint32_t stream_frames = 8;
  std::uint64_t stream_bytes = std::uint64_t{512} << 20U;

  /// Points of one cloud.
  std::uint64_t max_points = 16'000'000;
  /// Bytes of one cloud after decompression.
  std::uint64_t max_decoded_bytes = std::uint64_t{512} << 20U;
  /// Voxels of one cloud.
  std::uint64_t max_voxels = 4'000'000;
  /// Bytes of memory for all frames: payloads, clouds, the workspace of segmentation, and results until they are read.
  /// 0: 75 % of what the cgroup or the machine has.
  std::uint64_t memory = 0;
  /// How long a worker computes one frame at most, whatever its client says.
  std::chrono::milliseconds max_frame_time{60'000};
  /// Accept Draco payloads. Draco's library has known faults with hostile bytes.
  bool enable_draco = false;

  /// Serve gRPC's reflection, by which tools such as grpcurl learn the interface. gRPC's implementation bounds neither
  /// the memory of its messages nor its threads, so it is for trusted networks only.
  bool reflection = false;

  /// Calls in flight have this long to finish when the server stops. Then they are cancelled.
  std::chrono::milliseconds grace_period{20'000};

  /// A stopping server answers new calls with UNAVAILABLE (DRAINING) for at least this long, but no longer than the
  /// grace period, before it closes its connections. Calls that are on their way then learn what to do.
  std::chrono::milliseconds drain_delay{200};

  /// How a call is segmented that sets no options.
  Options defaults;
};

/// Every fault of the options at once, by the names of their flags; empty if the options are valid.
std::vector<FieldViolation> violations(const ServerOptions& options);

}  // namespace segserve::server
