// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "server/observe/frame_record.hpp"

namespace segserve::server {

/// The causes for which a server turns away frames and streams that are not wrong in themselves.
std::span<const char* const> refusal_causes();

/// The cause behind this status; null if it is no such refusal.
const char* refusal_cause(const StatusFacts& status, bool is_evicted);

}  // namespace segserve::server
