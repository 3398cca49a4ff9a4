// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include "core/lab/picture/raster.hpp"

namespace segserve::picture {
namespace {

/// A surface at the depth 1 that fills the middle of a picture. Point 1 is on it, and point 2 behind it.
Raster surface() {
  Raster raster(20, 20);
  for (std::size_t y = 5; y < 15; ++y) {
    for (std::size_t x = 5; x < 15; ++x) {
      raster.point[y * 20 + x] = 1;
      raster.depth[y * 20 + x] = 1.0F;
    }
  }
  return raster;
}

void put(Raster& raster, std::size_t x, std::size_t y, std::uint32_t point, float depth) {
  raster.point[y * 20 + x] = point;
  raster.depth[y * 20 + x] = depth;
}

TEST(CloseHoles, FillsHolesAndWhatShinesThroughThem) {
  Raster raster = surface();
  put(raster, 8, 8, Raster::kNoPoint, 0.0F);
  put(raster, 11, 11, 2, 3.0F);
  for (std::size_t y = 8; y < 11; ++y) put(raster, 12, y, Raster::kNoPoint, 0.0F);
  close_holes(raster);
  EXPECT_EQ(raster.point, surface().point);
  EXPECT_EQ(raster.depth, surface().depth);
}

TEST(CloseHoles, LeavesOutlinesAndLargeHoles) {
  Raster raster = surface();
  close_holes(raster);
  EXPECT_EQ(raster.point, surface().point);
  Raster window = surface();
  for (std::size_t y = 6; y < 14; ++y) {
    for (std::size_t x = 6; x < 14; ++x) put(window, x, y, 2, 3.0F);
  }
  close_holes(window);
  EXPECT_EQ(window.point[10 * 20 + 10], 2U);
}

TEST(CloseHoles, LeavesThingsInFrontAndSteps) {
  Raster raster = surface();
  put(raster, 8, 8, 3, 0.5F);     // a thin thing before the surface
  put(raster, 10, 10, 4, 1.02F);  // hardly behind its neighbors: part of the surface
  close_holes(raster);
  EXPECT_EQ(raster.point[8 * 20 + 8], 3U);
  EXPECT_EQ(raster.point[10 * 20 + 10], 4U);
}

}  // namespace
}  // namespace segserve::picture
