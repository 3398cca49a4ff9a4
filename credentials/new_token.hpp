// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "absl/status/statusor.h"

namespace segserve::credentials {

/// A token that nobody can guess: "segserve_" and 256 random bits. The prefix lets scanners find tokens that were
/// published by mistake. UNAVAILABLE if the system gives no random bits.
absl::StatusOr<std::string> new_token();

}  // namespace segserve::credentials
