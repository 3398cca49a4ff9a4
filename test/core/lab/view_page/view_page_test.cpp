// SPDX-License-Identifier: Apache-2.0
#include "core/lab/view_page/view_page.hpp"

#include <gmock/gmock.h>
#include <zlib.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "absl/strings/escaping.h"
#include "core/lab/view_page/page_array.hpp"
#include "core/lab/view_page/supervoxel_neighbors.hpp"
#include "nlohmann/json.hpp"

namespace segserve::view_page {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Pair;

/// Returns the text between two others.
std::string between(const std::string& text, const std::string& begin, const std::string& end) {
  const std::size_t at = text.find(begin);
  if (at == std::string::npos) return "";
  return text.substr(at + begin.size(), text.find(end, at) - at - begin.size());
}

std::string gunzip(const std::string& base64) {
  std::string bytes, result(100, '\0');
  EXPECT_TRUE(absl::Base64Unescape(base64, &bytes));
  z_stream stream{};
  EXPECT_EQ(inflateInit2(&stream, 15 + 16), Z_OK);
  stream.next_in = reinterpret_cast<Bytef*>(bytes.data());
  stream.avail_in = static_cast<uInt>(bytes.size());
  stream.next_out = reinterpret_cast<Bytef*>(result.data());
  stream.avail_out = static_cast<uInt>(result.size());
  EXPECT_EQ(inflate(&stream, Z_FINISH), Z_STREAM_END);
  result.resize(stream.total_out);
  inflateEnd(&stream);
  return result;
}

TEST(PageArrays, StoresDifferencesInPlanesOfBytes) {
  PageArrays arrays;
  const std::vector<std::uint32_t> values{1, 258, 2};
  const auto json = arrays.add(std::span<const std::uint32_t>(values));
  EXPECT_EQ(json.dump(), R"({"type":"u32","count":3,"id":"array-1"})");
  const std::string planes = gunzip(std::move(arrays).texts()[0].second);
  // The differences are 1, 257 and -256.
  EXPECT_EQ(planes, std::string("\1\1\0"
                                "\0\1\377"
                                "\0\0\377"
                                "\0\0\377",
                                12));
}

TEST(PageArrays, NumbersItsElements) {
  PageArrays arrays;
  const std::vector<float> floats{1.5F};
  const std::vector<double> none;
  EXPECT_EQ(arrays.add(std::span<const float>(floats))["id"], "array-1");
  EXPECT_EQ(arrays.add(std::span<const double>(none)).dump(), R"({"type":"f64","count":0,"id":"array-2"})");
  EXPECT_EQ(gunzip(std::move(arrays).texts()[1].second), "");
}

/// Points in a row, 1 cm apart.
Cloud row_of_points(std::uint32_t count, View view) {
  Cloud cloud;
  cloud.view = view;
  cloud.resize(count, false);
  cloud.width = count;
  cloud.height = 1;
  for (std::uint32_t i = 0; i < count; ++i) {
    cloud.x[i] = 0.01F * static_cast<float>(i);
    cloud.y[i] = 0;
    cloud.z[i] = 2;
  }
  return cloud;
}

TEST(SupervoxelNeighbors, AreThoseWhoseVoxelsTouch) {
  const Cloud cloud = row_of_points(40, View::world());
  std::vector<std::uint32_t> supervoxels(40, 0);
  for (std::size_t i = 0; i < 40; ++i) supervoxels[i] = static_cast<std::uint32_t>(1 + i / 10);
  std::fill(supervoxels.begin() + 28, supervoxels.begin() + 33, 0);  // A gap before the last one.
  const auto neighbors = supervoxel_neighbors(cloud, supervoxels, 0.02);
  EXPECT_THAT(neighbors.pairs, ElementsAre(Pair(0, 1), Pair(1, 2)));
  EXPECT_NEAR(neighbors.spacing, 0.02 / std::sqrt(2), 1e-9);
}

TEST(SupervoxelNeighbors, GrowWithTheDepthOfACamera) {
  const Cloud cloud = row_of_points(4, View::camera());
  const std::vector<std::uint32_t> supervoxels{1, 0, 0, 2};  // They are 3 cm apart, at a depth of 2 m.
  EXPECT_THAT(supervoxel_neighbors(cloud, supervoxels, 0.015).pairs, ElementsAre(Pair(0, 1)));
  EXPECT_THAT(supervoxel_neighbors(cloud, supervoxels, 0.005).pairs, IsEmpty());
}

constexpr std::string_view kBundle = "<html><body><!--DATA--><script>run()</script></body></html>";

struct Scene {
  Cloud cloud = row_of_points(6, View::world());
  Segmentation segmentation;
  std::vector<std::uint32_t> truth{7, 7, 7, 9, 9, 0};

  Scene() {
    cloud.x[5] = std::numeric_limits<float>::quiet_NaN();
    segmentation.supervoxels = {1, 1, 1, 2, 2, 0};
    segmentation.tree =
        *complete({.leaf_points = {3, 2}, .left = {0}, .right = {1}, .weight = {0.25}, .merged_rows = 1});
    segmentation.resolution.voxel = 0.02;
    segmentation.threshold = 0.5;
  }
  absl::StatusOr<std::string> page(const std::string& name) const {
    const std::vector<PageCloud> clouds{{.points = cloud, .truth = truth, .placement = {}}};
    const std::vector<PageResult> results{
        {.name = name, .method = "border", .cloud = 0, .segmentation = &segmentation, .regions = std::nullopt}};
    return make_page(kBundle, name, clouds, results);
  }
};

nlohmann::json data_of(const std::string& page) {
  return nlohmann::json::parse(between(page, R"(<script type="application/json" id="page-data">)", "</script>"));
}

TEST(ViewPage, HasTheDataBeforeTheScript) {
  const auto page = Scene().page("scene.pcd");
  ASSERT_TRUE(page.ok()) << page.status();
  EXPECT_LT(page->find("page-data"), page->find("run()"));
  const auto json = data_of(*page);
  EXPECT_EQ(json["title"], "scene.pcd");
  EXPECT_EQ(json["clouds"][0]["arrays"]["x"]["count"], 5);  // Without the point that is not finite.
  EXPECT_THAT(json["clouds"][0]["truth_labels"], ElementsAre(0, 7, 9));
  EXPECT_EQ(json["results"][0]["merged_rows"], 1);
  EXPECT_EQ(json["results"][0]["threshold"], 0.5);
  EXPECT_EQ(json["results"][0]["arrays"]["edges"]["count"], 2);
}

TEST(ViewPage, HoldsNamesAsTextOnly) {
  const std::string name = "</script><script>alert(1)</script><!--<img src=x onerror=alert(2)>\xff\xe2\x80\xa8";
  const auto page = Scene().page(name);
  ASSERT_TRUE(page.ok());
  const auto count = [](const std::string& text, const std::string& what) {
    std::size_t found = 0;
    for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + 1)) ++found;
    return found;
  };
  const auto usual = Scene().page("scene.pcd");
  EXPECT_EQ(count(*page, "<"), count(*usual, "<"));
  EXPECT_EQ(data_of(*page)["title"], "</script><script>alert(1)</script><!--<img src=x onerror=alert(2)>\uFFFD\u2028");
}

TEST(ViewPage, RefusesArraysThatDoNotFit) {
  Scene scene;
  scene.segmentation.supervoxels.pop_back();
  EXPECT_THAT(std::string(scene.page("a").status().message()), HasSubstr("of 5 points, but the cloud has 6"));
  scene.segmentation.supervoxels.push_back(3);
  EXPECT_THAT(std::string(scene.page("a").status().message()), HasSubstr("supervoxel 3 is not a leaf"));
}

}  // namespace
}  // namespace segserve::view_page
