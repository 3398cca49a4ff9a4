// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "segserve/cloud.hpp"
#include "segserve/codec/warning.hpp"
#include "segserve/segment.hpp"

namespace segserve::wire {

/// What the owner of a cloud should know of its segmentation in this kind of view: points that were left out, and a
/// preset, a resolution or a unit that does not fit.
std::vector<codec::Warning> warnings_of(const Segmentation& segmentation, ViewKind view);

}  // namespace segserve::wire
