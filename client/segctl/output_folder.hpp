// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "absl/status/status.h"

namespace segserve::segctl {

/// Makes the folder of --out-dir, and those that it lies in, if it is missing. INVALID_ARGUMENT if that is not
/// possible.
absl::Status make_folder(const std::string& path);

}  // namespace segserve::segctl
