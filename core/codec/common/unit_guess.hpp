// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "core/base/stop_check.hpp"
#include "core/codec/common/column.hpp"
#include "segserve/codec/warning.hpp"

namespace segserve::codec {

/// The meters a unit of coordinates that LengthUnit::kAuto stands for: 1 or 0.001. A warning tells what was taken, and
/// why. Once `check` has stopped, the result means nothing.
double guess_unit(const std::array<Column, 3>& columns, std::size_t points, StopCheck& check,
                  std::vector<Warning>& warnings);

}  // namespace segserve::codec
