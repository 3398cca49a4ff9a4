// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "absl/status/statusor.h"
#include "client/load_test/load.hpp"
#include "client/segctl/bench_arguments.hpp"

namespace segserve::segctl {

/// The frames that the flags ask for: of files, of a recording, or synthetic ones. INVALID_ARGUMENT for flags that do
/// not fit them; other errors as of the readers, with the name of the file.
absl::StatusOr<bench::FrameSource> frame_source(const BenchArguments& arguments);

}  // namespace segserve::segctl
