// SPDX-License-Identifier: Apache-2.0
#include "segserve/codec/length_unit.hpp"

#include <algorithm>
#include <array>

namespace segserve::codec {
namespace {

struct Entry {
  LengthUnit unit;
  std::string_view name;
  double meters;
};

constexpr std::array<Entry, 6> kUnits{{
    {LengthUnit::kMeter, "m", 1},
    {LengthUnit::kCentimeter, "cm", 0.01},
    {LengthUnit::kMillimeter, "mm", 0.001},
    {LengthUnit::kInch, "in", 0.0254},
    {LengthUnit::kFoot, "ft", 0.3048},
    {LengthUnit::kAuto, "auto", 1},
}};

}  // namespace

std::span<const LengthUnit> length_units() {
  static constexpr std::array<LengthUnit, 5> kAll{LengthUnit::kMeter, LengthUnit::kCentimeter, LengthUnit::kMillimeter,
                                                  LengthUnit::kInch, LengthUnit::kFoot};
  return kAll;
}

std::string_view name(LengthUnit unit) { return std::ranges::find(kUnits, unit, &Entry::unit)->name; }

std::optional<LengthUnit> length_unit_from_name(std::string_view name) {
  const auto* const found = std::ranges::find(kUnits, name, &Entry::name);
  return found == kUnits.end() ? std::nullopt : std::optional(found->unit);
}

double meters_per_unit(LengthUnit unit) { return std::ranges::find(kUnits, unit, &Entry::unit)->meters; }

std::optional<LengthUnit> length_unit_of(double meters) {
  const auto* const found = std::ranges::find(kUnits, meters, &Entry::meters);
  return found == kUnits.end() ? std::nullopt : std::optional(found->unit);
}

}  // namespace segserve::codec
