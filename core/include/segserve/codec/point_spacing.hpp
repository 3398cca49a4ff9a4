// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "segserve/cloud.hpp"
#include "segserve/stop_token.hpp"

namespace segserve::codec {

/// The median distance of a point from its nearest neighbor at another position, in the unit of the cloud, over a
/// sample of up to 512 points. The search of one point looks at no more than 20,000 others, which is enough but in the
/// densest clouds, where the result may be too large. nullopt if fewer than two finite points differ; meaningless once
/// `stop` says stop.
std::optional<double> point_spacing(const CloudView& cloud, const StopToken& stop = {});

}  // namespace segserve::codec
