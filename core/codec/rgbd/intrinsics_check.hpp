// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string_view>

#include "core/codec/rgbd/image_size.hpp"
#include "segserve/codec/rgbd.hpp"
#include "segserve/codec/warning.hpp"

namespace segserve::codec {

/// A warning if intrinsics that are valid can hardly be those of an image of this size: the principal point lies
/// outside or far from the middle, the field of view is absurd, or the two focal lengths differ much. Most often they
/// belong to another resolution of the same camera. Images of less than 16 pixels on a side are not judged. `image` is
/// "depth" or "color".
std::optional<Warning> odd_intrinsics(std::string_view image, const Intrinsics& intrinsics, const ImageSize& size);

}  // namespace segserve::codec
