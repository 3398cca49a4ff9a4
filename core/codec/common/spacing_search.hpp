// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "core/base/stop_check.hpp"
#include "segserve/cloud.hpp"

namespace segserve::codec {

/// point_spacing within a stage that has a StopCheck.
std::optional<double> point_spacing(const CloudView& cloud, StopCheck& check);

}  // namespace segserve::codec
