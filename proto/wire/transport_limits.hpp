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

/// The window of HTTP/2's flow control with which a stream begins, on both sides: the bytes that the other side may
/// send ahead. gRPC makes the window of the connection, which has 64 KiB at first, as large as bandwidth and round trip
/// ask for; without its probes, a round trip of 100 ms would leave 5 Mbit/s (test/e2e/test_impaired_link.py).
inline constexpr int kFlowControlBytes = 4 << 20;

}  // namespace segserve::wire
