// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "segserve/cloud.hpp"
#include "segserve/codec/length_unit.hpp"

namespace segserve::codec {

/// The facts that the reader of a file knows better than the file.
struct ReadOptions {
  /// Where the sensor is, in meters along the axes of the file. Unset: as the file says, or as its points make plain
  /// (see LabeledCloud::view_rule).
  std::optional<View> view = std::nullopt;
  /// The unit of the coordinates in the file. Unset: as the file says, by a statement of segserve, the names of its
  /// columns or its coordinate reference system, or else meters.
  std::optional<LengthUnit> unit = std::nullopt;
  /// Whether LabeledCloud::file_position and ::attributes are wanted, because the cloud will be written again.
  bool keep_everything = false;
};

}  // namespace segserve::codec
