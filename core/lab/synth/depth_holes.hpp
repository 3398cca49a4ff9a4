// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "core/lab/synth/depth_raster.hpp"
#include "core/math/random.hpp"

/// Holes in depth images: each function sets the depths of pixels that a sensor cannot measure to 0.
namespace segserve::synth {

/// Removes the pixels that the camera sees and its partner on the right (a projector or a second camera) does not. Each
/// row is resampled at the columns of the partner, where the largest disparity wins. `focal_times_baseline` is in
/// pixels times meters.
void cut_shadow(DepthImage& image, double focal_times_baseline);

/// Removes surfaces that the rays only graze, in patches rather than single pixels.
void cut_grazing(DepthImage& image, std::uint64_t seed);

/// Removes a few spots, like those of glints and dark dots, at random places.
void cut_spots(DepthImage& image, Random& random);

}  // namespace segserve::synth
