// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "core/base/stop_check.hpp"
#include "segserve/cloud.hpp"

namespace segserve::codec {

/// The median distance of a point from its nearest neighbor at another position, in the unit of the cloud, over a
/// sample of up to 512 points. The search of one point looks at no more than 20,000 others, which is enough but in the
/// densest clouds, where the result may be too large. nullopt if fewer than two finite points differ.
std::optional<double> point_spacing(const CloudView& cloud, StopCheck& check);

}  // namespace segserve::codec
