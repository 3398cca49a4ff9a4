// SPDX-License-Identifier: Apache-2.0
#include "core/lab/picture/contact_sheet.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <limits>

#include "core/lab/picture/canvas.hpp"
#include "core/lab/picture/legend.hpp"

namespace segserve::picture {
namespace {

bool has(const Image& image, std::uint32_t rgb) {
  for (std::size_t i = 0; i < image.rgb.size(); i += 3) {
    if (pack_rgb(image.rgb[i], image.rgb[i + 1], image.rgb[i + 2]) == rgb) return true;
  }
  return false;
}

TEST(ContactSheet, HasEveryPictureAndIsAboutFourByThree) {
  std::vector<SheetEntry> entries(30);
  for (std::uint32_t i = 0; i < 30; ++i) {
    entries[i].name = "a-long-name-of-a-file-that-does-not-fit.pcd";
    entries[i].note = "12 segments";
    entries[i].picture = blank_image(40, 30, 0x100000 + i);
  }
  const Image sheet = make_contact_sheet(entries, "30 files");
  for (std::uint32_t i = 0; i < 30; ++i) EXPECT_TRUE(has(sheet, 0x100000 + i)) << i;
  EXPECT_NEAR(static_cast<double>(sheet.width) / sheet.height, 4.0 / 3.0, 0.35);
}

TEST(ContactSheet, OfOneOrNoneIsAPicture) {
  EXPECT_GT(make_contact_sheet({}, "0 files").width, 60U);
  const std::vector<SheetEntry> one(1);
  EXPECT_GE(make_contact_sheet(one, "1 files").width, kSheetPictureWidth);
}

TEST(SheetPicture, OfACloudWithoutPointsSaysSo) {
  Cloud cloud;
  cloud.resize(20, false);
  std::ranges::fill(cloud.z, std::numeric_limits<float>::quiet_NaN());
  for (const Image& image : {sheet_picture(cloud, std::vector<std::uint32_t>(20)), sheet_picture(Cloud{}, {})}) {
    EXPECT_EQ(image.width, kSheetPictureWidth);
    EXPECT_TRUE(has(image, kFaintTextColor));
  }
  cloud.z.front() = 1;
  EXPECT_FALSE(has(sheet_picture(cloud, std::vector<std::uint32_t>(20)), kFaintTextColor));
}

TEST(SheetPicture, FitsItsPlace) {
  for (const auto& [width, height] : {std::pair(640U, 480U), std::pair(64U, 1000U), std::pair(3000U, 2U)}) {
    Cloud cloud;
    cloud.resize(std::size_t{width} * height, false);
    cloud.width = width;
    cloud.height = height;
    for (float& z : cloud.z) z = 1;
    const Image image = sheet_picture(cloud, std::vector<std::uint32_t>(cloud.size(), 1));
    EXPECT_LE(image.width, kSheetPictureWidth);
    EXPECT_LE(image.height, kSheetPictureHeight);
    EXPECT_EQ(image.rgb.size(), std::size_t{3} * image.width * image.height);
  }
  Cloud loose;
  loose.view = View::world();
  EXPECT_LE(sheet_picture(loose, {}).width, kSheetPictureWidth);
}

}  // namespace
}  // namespace segserve::picture
