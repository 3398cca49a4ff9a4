// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>

#include "segserve/codec/labeled_cloud.hpp"

namespace segserve::segctl {

/// The points with these indices, in this order, as a cloud that is not organized, with everything that its file had
/// for them but labels.
codec::LabeledCloud subset_of(const codec::LabeledCloud& scene, std::span<const std::size_t> points);

}  // namespace segserve::segctl
