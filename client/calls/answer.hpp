#pragma once

#include "absl/status/statusor.h"
#include "proto/wire/request_message.hpp"
#include "proto/wire/result_message.hpp"

namespace segserve::client {

/// What a server answered, if it holds what was asked for. INTERNAL otherwise: a bad answer is the server's fault,
/// not the caller's.
absl::StatusOr<wire::Result> check_answer(absl::StatusOr<wire::Result> result, const wire::Outputs& wanted);

}  // namespace segserve::client
