// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "core/lab/synth/depth_raster.hpp"
#include "core/lab/synth/lighting.hpp"
#include "core/lab/synth/pinhole_camera.hpp"
#include "core/lab/synth/scene.hpp"
#include "core/lab/synth/solid.hpp"

namespace segserve::synth {

/// The world as a perfect camera sees it.
struct Picture {
  DepthImage depth;
  std::vector<Vec3> color;  ///< sRGB, 0 to 1.
};
Picture render(const World& world, const Camera& camera, const Lighting& lighting, const ShadowMap& shadow);

/// Turns the depths of a picture into those that a sensor measures, in place. `focal` is in pixels.
void measure_depth(Sensor sensor, double focal, double noise, bool holes, Picture& picture, Random& random);

/// The organized cloud of a frame, in the CAMERA view. Pixels without depth are NaN, keep their color, and get label 0.
SyntheticScene to_cloud(const Camera& camera, const DepthImage& image, std::vector<std::uint32_t> rgb);

}  // namespace segserve::synth
