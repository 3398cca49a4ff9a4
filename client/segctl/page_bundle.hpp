// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

#include "absl/status/statusor.h"

namespace segserve::segctl {

/// The page of segctl view that client/page/build.js bundled, without data. INVALID_ARGUMENT, with the way to get it,
/// if this program was built without npm.
absl::StatusOr<std::string_view> page_bundle();

/// Returns the bundled page of segctl bench.
absl::StatusOr<std::string_view> bench_page_bundle();

}  // namespace segserve::segctl
