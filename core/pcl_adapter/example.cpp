// SPDX-License-Identifier: Apache-2.0
// Segments a PCD file with the types of PCL: segserve_pcl_example scene.pcd out.pcd
//
// out.pcd holds the same points and colors with a label each: 0 = not finite, 1, 2, .. segments
// by descending size.
#include <pcl/io/pcd_io.h>

#include <cstdio>
#include <exception>

#include "segserve/pcl_adapter.hpp"

namespace {

int run(const char* input, const char* output) {
  pcl::PointCloud<pcl::PointXYZRGBA> cloud;
  if (pcl::io::loadPCDFile(input, cloud) != 0) {
    fmt::print(stderr, "{}: cannot be read as a PCD file with x, y, z and rgba\n", input);
    return 2;
  }
  const segserve::View view = segserve::pcl_adapter::view_by_pcd_rule(cloud);
  const auto result = segserve::pcl_adapter::segment(cloud, view);
  if (!result.ok()) {
    fmt::print(stderr, "{}: {}\n", input, result.status().ToString());
    return 2;
  }
  fmt::print("{} points, {} supervoxels, {} segments at threshold {:.2f} in {:.1f} ms\n", cloud.size(),
             result->tree.leaf_count(), result->segments, *result->threshold, result->timings.total);

  // The tree holds every other segmentation of the scene: here the ten largest differences.
  const auto cut = segserve::cut_to_regions(result->tree, 10);
  if (cut.ok()) fmt::print("the same tree, cut to at most 10 regions: {} segments\n", cut->segments);

  const auto labeled = segserve::pcl_adapter::with_labels(cloud, result->labels);
  if (!labeled.ok() || pcl::io::savePCDFileBinaryCompressed(output, *labeled) != 0) {
    fmt::print(stderr, "{}: cannot be written\n", output);
    return 1;
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) {
    fmt::print(stderr, "usage: {} scene.pcd out.pcd\n", argv[0]);
    return 2;
  }
  try {
    return run(argv[1], argv[2]);
  } catch (const std::exception& error) {  // pcl::IOException of a file that cannot be opened
    fmt::print(stderr, "{}\n", error.what());
    return 1;
  }
}
