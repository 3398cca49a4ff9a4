#pragma once

#include <cstdint>

namespace segserve::wire {

/// A serialised SegmentRequest may have this many bytes; more must be streamed (to come).
inline constexpr std::uint64_t kMaxRequestBytes = std::uint64_t{8} << 20U;

/// What server and client set as gRPC's receive limit. For the server it is a little above
/// kMaxRequestBytes, so that slightly larger requests get our own error, which names the limit.
inline constexpr int kServerReceiveBytes = 9 << 20;

/// An answer with labels, supervoxels and tree of the largest cloud fits in.
inline constexpr int kClientReceiveBytes = 64 << 20;

}  // namespace segserve::wire
