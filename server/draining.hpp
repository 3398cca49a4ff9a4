#pragma once

#include "absl/status/status.h"

namespace segserve::server {

/// UNAVAILABLE, DRAINING: what a server that is about to stop says to new calls and frames.
absl::Status draining();

}  // namespace segserve::server
