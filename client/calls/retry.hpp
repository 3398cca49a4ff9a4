#pragma once

#include <string_view>

#include "absl/status/status.h"

namespace segserve::client {

/// Whether another try may succeed: UNAVAILABLE, RESOURCE_EXHAUSTED, ABORTED (checksum), an upload that stalled.
/// The caller's own CANCELLED must not be asked here: a server that shuts down ends calls as CANCELLED, too.
bool is_retryable(const absl::Status& status);

/// Whether a stream that ended with this status could do better on another connection. False for errors that
/// every server would answer again.
bool is_worth_reconnecting(const absl::Status& status);

/// UNAVAILABLE in place of the CANCELLED without details with which a server that shuts down ends calls.
absl::Status as_seen_by_a_caller_who_did_not_cancel(const absl::Status& status);

}  // namespace segserve::client
