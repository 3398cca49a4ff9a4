// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace segserve::server {

/// The place of a frame in a distributed trace. Identifiers are lower-case hexadecimal digits, as in
/// proto/wire/traceparent.hpp.
struct FrameTrace {
  std::string trace_id = {};   ///< empty: the frame belongs to no trace
  std::string parent_id = {};  ///< the client's span; empty: the trace begins here
  std::string span_id = {};    ///< of the frame itself; empty: it is not recorded
};

/// The place of a frame whose client sent this traceparent, or a text that is none, or nothing. With a valid one, the
/// client decides whether the frame is recorded. Else this share of frames, in [0, 1], begins a trace and is recorded.
/// Without a share, this server records no traces at all.
FrameTrace trace_of(std::string_view traceparent, std::optional<double> sampled_share);

}  // namespace segserve::server
