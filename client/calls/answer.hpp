// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "absl/status/statusor.h"
#include "proto/wire/request_message.hpp"
#include "proto/wire/result_message.hpp"

namespace segserve::client {

/// Passes on a result that holds the arrays of `wanted`. INTERNAL otherwise, because a bad answer is the fault of the
/// server and not of the caller.
absl::StatusOr<wire::Result> check_answer(absl::StatusOr<wire::Result> result, const wire::Outputs& wanted);

}  // namespace segserve::client
