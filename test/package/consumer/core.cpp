// SPDX-License-Identifier: Apache-2.0
// Segments two walls at a right angle and saves them as a file in memory.
#include <Eigen/Core>
#include <cstdio>
#include <string>

#include "segserve/cloud.hpp"
#include "segserve/codec/pcd.hpp"
#include "segserve/segment.hpp"
#include "segserve/segment_statistics.hpp"

int main() {
  constexpr int kSide = 100;
  segserve::Cloud cloud;
  cloud.view = segserve::View::world(0.25F, 0.25F, 2);
  for (int row = 0; row < kSide; ++row) {
    for (int column = 0; column < kSide; ++column) {
      const float a = 0.005F * static_cast<float>(row), b = 0.005F * static_cast<float>(column);
      cloud.x.insert(cloud.x.end(), {a, a});
      cloud.y.insert(cloud.y.end(), {b, 0});
      cloud.z.insert(cloud.z.end(), {0, b});
      cloud.rgb.insert(cloud.rgb.end(), {segserve::pack_rgb(90, 120, 150), segserve::pack_rgb(200, 60, 60)});
    }
  }
  cloud.width = static_cast<std::uint32_t>(cloud.size());
  cloud.height = 1;

  segserve::Segmenter segmenter;
  absl::StatusOr<segserve::Segmentation> result = segmenter.segment(cloud, {});
  if (!result.ok() || !segserve::describe(cloud, 1, {}, *result).ok()) return 1;
  const Eigen::Vector3d centroid = result->statistics.at(0).centroid;
  const std::string file = segserve::codec::encode_pcd(cloud, result->labels, segserve::codec::PcdEncoding::kBinary);
  std::printf("%u segments, the first around (%.2f, %.2f, %.2f) m, a file of %zu bytes\n", result->segments,
              centroid.x(), centroid.y(), centroid.z(), file.size());
  return result->segments >= 2 && file.size() > result->labels.size() ? 0 : 1;
}
