// SPDX-License-Identifier: Apache-2.0
#include "test/bench/frames.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <filesystem>
#include <string_view>
#include <utility>

#include "core/lab/synth/scene.hpp"
#include "segserve/codec/cloud_file.hpp"

namespace segserve::bench {
namespace {

/// Fills the holes of an organized cloud of a Kinect (640 x 480). A pixel without depth gets the depth of the nearest
/// pixel to its left in the same row, else of the nearest to its right, else 1.2 m.
Cloud filled(Cloud cloud) {
  constexpr std::size_t kWidth = 640;
  constexpr float kFocalLength = 525, kCenterX = 319.5, kCenterY = 239.5;
  for (std::size_t row = 0; row * kWidth < cloud.size(); ++row) {
    const auto z = cloud.z.begin() + static_cast<std::ptrdiff_t>(row * kWidth);
    const auto is_depth = [](float depth) { return std::isfinite(depth); };
    const auto first = std::find_if(z, z + kWidth, is_depth);
    float last = first == z + kWidth ? 1.2F : *first;
    for (std::size_t column = 0; column < kWidth; ++column) {
      const std::size_t i = row * kWidth + column;
      if (is_depth(cloud.z[i])) {
        last = cloud.z[i];
        continue;
      }
      cloud.x[i] = (static_cast<float>(column) - kCenterX) / kFocalLength * last;
      cloud.y[i] = (static_cast<float>(row) - kCenterY) / kFocalLength * last;
      cloud.z[i] = last;
    }
  }
  return cloud;
}

void add_real(std::vector<Frame>& frames) {
  const std::filesystem::path folder = std::filesystem::path(SEGSERVE_DATA_DIR) / "osd/learn";
  for (const char* scene : {"learn5", "learn20", "learn30", "learn40"}) {
    auto frame = codec::load_cloud(folder / (std::string(scene) + ".pcd"));
    if (!frame.ok()) {
      std::fprintf(stderr, "no real frame: %s\n", std::string(frame.status().message()).c_str());
      continue;
    }
    if (std::string_view(scene) == "learn20") frames.push_back({"osd-learn20-full", filled(frame->cloud)});
    frames.push_back({std::string("osd-") + scene, std::move(frame->cloud)});
  }
}

}  // namespace

const std::vector<Frame>& frames() {
  static const std::vector<Frame> all = [] {
    std::vector<Frame> frames;
    add_real(frames);
    frames.push_back({"synthetic", synth::make_tabletop({.seed = 1})->cloud});
    frames.push_back({"synthetic-full", synth::make_tabletop({.seed = 1, .all_finite = true})->cloud});
    return frames;
  }();
  return all;
}

}  // namespace segserve::bench
