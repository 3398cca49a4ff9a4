// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace segserve::wire {

/// The largest size of a serialized SegmentRequest, bytes. Larger clouds must be streamed.
inline constexpr std::uint64_t kMaxRequestBytes = std::uint64_t{8} << 20U;

/// The receive limit that a server sets for gRPC, bytes. It is a little above kMaxRequestBytes, so that slightly larger
/// requests get our own error, which names the limit.
inline constexpr int kServerReceiveBytes = 9 << 20;

/// The receive limit that a client sets for gRPC, bytes. It suffices for the labels, the supervoxels and the tree of 7
/// million points.
inline constexpr int kClientReceiveBytes = 64 << 20;

/// The window of HTTP/2's flow control on both sides: the bytes that the other side may send ahead. A fixed window
/// keeps gRPC from probing for one, whose pings delay frames. It suffices for 100 Mbit/s over a round trip of 300 ms.
inline constexpr int kFlowControlBytes = 4 << 20;

}  // namespace segserve::wire
