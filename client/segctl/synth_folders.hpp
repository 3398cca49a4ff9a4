// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "absl/status/status.h"
#include "client/segctl/synth_arguments.hpp"

namespace segserve::segctl {

/// Labels of the ground truth from this one on are those of objects.
inline constexpr std::uint32_t kFirstObjectLabel = 20;

/// Writes what several cameras around a table see to the folder of --rig, and where they stand; tells what it wrote.
absl::Status write_rig(const SynthArguments& arguments);

/// Writes the frames of a table over time to the folder of --moving, one by one, because a long sequence does not fit
/// into memory; tells what it wrote.
absl::Status write_moving(const SynthArguments& arguments);

}  // namespace segserve::segctl
