#pragma once

#include <cstdint>
#include <vector>

#include "core/lab/synth/shape.hpp"
#include "core/lab/synth/texture.hpp"

namespace segserve::synth {

/// A shape in the world: z up, metres.
struct Solid {
  Shape shape;
  Pose pose;
  Texture texture;
  std::uint32_t label = 0;  ///< ground truth: 1..9 support, 20, 30, .. objects
};

using World = std::vector<Solid>;

}  // namespace segserve::synth
