// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace segserve::wire {

/// A serialized SegmentRequest may have this many bytes; more must be streamed.
inline constexpr std::uint64_t kMaxRequestBytes = std::uint64_t{8} << 20U;

/// What server and client set as gRPC's receive limit. For the server it is a little above
/// kMaxRequestBytes, so that slightly larger requests get our own error, which names the limit.
inline constexpr int kServerReceiveBytes = 9 << 20;

/// An answer with labels, supervoxels and tree of the largest cloud fits in.
inline constexpr int kClientReceiveBytes = 64 << 20;

/// What HTTP/2 lets the other side send ahead, on both sides, instead of gRPC's probing for it: the pings of the probe
/// cost 1.5 ms of a raw frame of 307,200 points over loopback. Enough for 100 Mbit/s over 300 ms of round trip.
inline constexpr int kFlowControlBytes = 4 << 20;

}  // namespace segserve::wire
