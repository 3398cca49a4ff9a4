// SPDX-License-Identifier: Apache-2.0
#include <iterator>
#include <string>
#include <string_view>

#include "core/lab/synth/moving_tabletop.hpp"
#include "core/lab/synth/scene.hpp"
#include "fmt/format.h"

namespace segserve::synth {
namespace {

/// Collects every option that is out of its range.
class Violations {
 public:
  void require(std::string_view name, double value, double low, double high) {
    if (value >= low && value <= high) return;  // This is false for NaN.
    fmt::format_to(std::back_inserter(text_), "{}{} is {}, must be in [{}, {}]", text_.empty() ? "" : "; ", name, value,
                   low, high);
  }
  void require(bool fulfilled, std::string_view message) {
    if (!fulfilled) fmt::format_to(std::back_inserter(text_), "{}{}", text_.empty() ? "" : "; ", message);
  }
  absl::Status status() const { return text_.empty() ? absl::OkStatus() : absl::InvalidArgumentError(text_); }

 private:
  std::string text_;
};

void require_all(const SceneOptions& options, Violations& violations) {
  violations.require("width", options.width, 16, 4096);
  violations.require("height", options.height, 16, 4096);
  violations.require("objects", options.objects, 0, 40);
  violations.require("stacked", options.stacked, 0, 1);
  violations.require("clutter", options.clutter, 0, 1);
  violations.require("noise", options.noise, 0, 10);
  violations.require("distance", options.distance, 0.5, 3);
  violations.require(!(options.hollow && options.compact), "hollow and compact exclude each other");
}

}  // namespace

absl::Status check(const SceneOptions& options) {
  Violations violations;
  require_all(options, violations);
  return violations.status();
}

absl::Status check(const MovingOptions& options) {
  Violations violations;
  require_all(options.scene, violations);
  violations.require("rate", options.rate, 0.1, 120);
  violations.require("frames", options.frames, 1, 100'000);
  violations.require("camera_motion", options.camera_motion, 0, 5);
  violations.require("moving", options.moving, 0, 40);
  violations.require("speed", options.speed, 0, 2);
  return violations.status();
}

absl::Status check(const RoomViewOptions& options) {
  Violations violations;
  violations.require("width", options.width, 16, 4096);
  violations.require("height", options.height, 16, 4096);
  violations.require("size", options.size, 0.7, 10);
  violations.require("objects", options.objects, 0, 60);
  violations.require("noise", options.noise, 0, 10);
  return violations.status();
}

absl::Status check(const RoomOptions& options) {
  Violations violations;
  violations.require("points", options.points, 1000, 20e6);
  violations.require("size", options.size, 0.7, 10);
  violations.require("objects", options.objects, 0, 60);
  violations.require("noise", options.noise, 0, 10);
  return violations.status();
}

absl::Status check(const LidarOptions& options) {
  Violations violations;
  const std::uint32_t rings = options.rings;
  violations.require(rings == 16 || rings == 32 || rings == 64 || rings == 128,
                     fmt::format("rings is {}, must be 16, 32, 64 or 128", rings));
  violations.require("columns", options.columns, 64, 8192);
  violations.require("size", options.size, 0.7, 10);
  violations.require("objects", options.objects, 0, 60);
  violations.require("noise", options.noise, 0, 10);
  return violations.status();
}

}  // namespace segserve::synth
