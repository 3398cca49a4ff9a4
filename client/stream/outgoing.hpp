#pragma once

#include <memory>
#include <string_view>

#include "proto/wire/byte_run.hpp"
#include "segserve/v1/stream.pb.h"

namespace segserve::client {

/// A message of a stream on its way out. The bytes of a chunk stay where they are, up to the socket.
struct Outgoing {
  v1::SegmentStreamRequest message;
  /// Of a message that is a chunk: its `data`, which is empty there.
  std::string_view data;
  std::shared_ptr<const wire::ByteRun> owner;  ///< of `data`
};

}  // namespace segserve::client
