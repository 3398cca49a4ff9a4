// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace segserve::codec {

/// Why a part of a file was not used, although the file was read.
enum class WarningReason : std::uint8_t {
  kColorNotUsed,  ///< fields that look like color are of no known kind
  kLabelNotUsed,  ///< labels are not whole numbers of 32 bits
  kRowsNotUsed,   ///< rows beyond those that the header promises, or damaged rows that are not needed
  /// points that are no measurement: zeros in a camera frame, 65535 in a depth image, single points beyond the grid
  kPointsNotUsed,
  kAttributeNotKept,  ///< values that mean nothing to the segmentation, and will not go out again
  kTooSparse,         ///< nearly every voxel holds a single point: the unit or the voxel resolution is probably wrong
  kTooDense,          ///< thousands of points lie in a few voxels: the unit or the voxel resolution is probably wrong
  kNoPoints,          ///< no point was segmented
  kUnitGuessed,       ///< the unit of the coordinates was guessed, as asked for
  kImageDamaged,      ///< bytes of an image are damaged or missing
  kColorMissing,      ///< points that the color image does not show
  /// coordinates so far from 0 that floats of 32 bits, which the file has, are coarse beside the distance of the points
  kCoordinatesRounded,
  kPresetNotFit,        ///< the preset has no effect on the cloud
  kIntrinsicsUnlikely,  ///< intrinsics of a camera can hardly be those of the image
  kScaleNotUsed,        ///< the scale that the header of a depth image tells
  kOther,               ///< a reason that this version does not know
};

/// "COLOR_NOT_USED" and so on, for programs.
std::string_view name(WarningReason reason);
/// kOther for names that this version does not know.
WarningReason warning_reason(std::string_view name);

/// Something that the owner of a file should know although the file was read.
struct Warning {
  WarningReason reason;
  std::string message;  ///< one line for people
};

}  // namespace segserve::codec
