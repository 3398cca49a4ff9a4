// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

namespace segserve::codec {

/// The unit of the coordinates in a file or payload.
enum class LengthUnit : std::uint8_t {
  kMeter,
  kCentimeter,
  kMillimeter,
  kInch,  ///< 0.0254 m
  kFoot,  ///< the international foot, 0.3048 m
  /// Meters or millimeters, as the distance between neighboring points makes plain: points that are 0.7 units or more
  /// apart in the median, or whole numbers that reach over 100 units, are millimeters.
  kAuto,
};

/// All units but kAuto.
std::span<const LengthUnit> length_units();

/// "m", "cm", "mm", "in", "ft" or "auto".
std::string_view name(LengthUnit unit);
/// The unit with this name; nullopt if there is none.
std::optional<LengthUnit> length_unit_from_name(std::string_view name);
/// Meters a unit. The unit must not be kAuto.
double meters_per_unit(LengthUnit unit);
/// The unit that is so many meters; nullopt if there is none.
std::optional<LengthUnit> length_unit_of(double meters);

}  // namespace segserve::codec
