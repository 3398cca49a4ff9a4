// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "core/base/stop_check.hpp"
#include "core/codec/common/point_columns.hpp"
#include "segserve/codec/decode_limits.hpp"

// Units and colors that programs write into the comments of OBJ files.
namespace segserve::codec {

/// Notes the unit of the coordinates, as SketchUp writes "# File units = inches", and the colors that ZBrush paints on
/// vertices, as "#MRGB" and eight hexadecimal digits for each: a mask, red, green and blue.
class ObjComments {
 public:
  /// Takes a line that begins with #. Colors count towards the limits. CANCELLED, DEADLINE_EXCEEDED.
  absl::Status take(std::string_view line, const DecodeLimits& limits, StopCheck& check);

  /// The unit that a comment tells; one that is not known is doubtful.
  const std::optional<ToldUnit>& unit() const { return unit_; }
  bool has_paint() const { return has_paint_; }
  /// One color for each vertex, without the mask; empty if any is damaged.
  const std::vector<std::uint32_t>& paint() const { return paint_; }

 private:
  std::optional<ToldUnit> unit_;
  std::vector<std::uint32_t> paint_;
  bool has_paint_ = false, is_damaged_ = false;
};

}  // namespace segserve::codec
