// SPDX-License-Identifier: Apache-2.0
#include "segserve/codec/warning.hpp"

#include <algorithm>
#include <array>

namespace segserve::codec {
namespace {

struct Entry {
  WarningReason reason;
  std::string_view name;
};

constexpr std::array<Entry, 16> kReasons{{
    {WarningReason::kColorNotUsed, "COLOR_NOT_USED"},
    {WarningReason::kLabelNotUsed, "LABEL_NOT_USED"},
    {WarningReason::kRowsNotUsed, "ROWS_NOT_USED"},
    {WarningReason::kPointsNotUsed, "POINTS_NOT_USED"},
    {WarningReason::kAttributeNotKept, "ATTRIBUTE_NOT_KEPT"},
    {WarningReason::kTooSparse, "TOO_SPARSE"},
    {WarningReason::kTooDense, "TOO_DENSE"},
    {WarningReason::kNoPoints, "NO_POINTS"},
    {WarningReason::kUnitGuessed, "UNIT_GUESSED"},
    {WarningReason::kImageDamaged, "IMAGE_DAMAGED"},
    {WarningReason::kColorMissing, "COLOR_MISSING"},
    {WarningReason::kCoordinatesRounded, "COORDINATES_ROUNDED"},
    {WarningReason::kPresetNotFit, "PRESET_NOT_FIT"},
    {WarningReason::kIntrinsicsUnlikely, "INTRINSICS_UNLIKELY"},
    {WarningReason::kScaleNotUsed, "SCALE_NOT_USED"},
    {WarningReason::kOther, "OTHER"},
}};

}  // namespace

std::string_view name(WarningReason reason) { return std::ranges::find(kReasons, reason, &Entry::reason)->name; }

WarningReason warning_reason(std::string_view name) {
  const auto* const found = std::ranges::find(kReasons, name, &Entry::name);
  return found == kReasons.end() ? WarningReason::kOther : found->reason;
}

}  // namespace segserve::codec
