// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/stop_check.hpp"
#include "segserve/cloud.hpp"

// Points that no sensor at the origin can have seen, because others are in front of them. Points that are not finite,
// and those at the origin, are ignored. Once the StopCheck has stopped, results mean nothing.
namespace segserve::codec {

/// Whether so many points lie far behind others that no sensor there has seen them all.
bool hide_one_another(const CloudView& cloud, StopCheck& check);

/// Whether so many points lie in a second layer behind others, as those of a closed surface do, that no sensor there
/// has seen them all. The layers may be close to each other, unlike those of hide_one_another. Judges by a sample of
/// the points that does not depend on their order.
bool lie_in_layers(const CloudView& cloud, StopCheck& check);

}  // namespace segserve::codec
