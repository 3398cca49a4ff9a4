// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>

#include "proto/wire/byte_run.hpp"
#include "segserve/client/payload.hpp"
#include "segserve/v1/cloud.pb.h"

namespace segserve::client {

/// The contents of a Payload.
struct PayloadData {
  v1::Cloud header;  ///< the message without the bytes of its blocks
  std::shared_ptr<const wire::ByteRun> run = std::make_shared<const wire::ByteRun>();  ///< those bytes; never null
  std::uint64_t points = 0;                                                            ///< 0: not known
  std::uint64_t decoded_bytes = 0;  ///< as in v1.FrameHeader; 0: not known
};

/// Takes the bytes out of the message.
Payload make_payload(v1::Cloud message, std::uint64_t points = 0, std::uint64_t decoded_bytes = 0);

/// The message with its bytes.
v1::Cloud message_of(const Payload& payload);

}  // namespace segserve::client
