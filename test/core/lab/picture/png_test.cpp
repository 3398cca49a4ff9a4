// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <png.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "core/lab/picture/picture.hpp"
#include "test/temporary_path.hpp"

namespace segserve::picture {
namespace {

Image sample_image(std::uint32_t width, std::uint32_t height) {
  Image image{width, height, {}};
  for (std::size_t i = 0; i < std::size_t{3} * width * height; ++i) {
    image.rgb.push_back(static_cast<std::uint8_t>(i * 37 + i / 7));
  }
  return image;
}

TEST(WritePng, LibpngReadsTheSamePixels) {
  const std::string path = test::temporary_path("picture.png");
  for (const Image& image : {sample_image(1, 1), sample_image(17, 9), sample_image(640, 3)}) {
    ASSERT_TRUE(write_png(path, image).ok());
    png_image png{};
    png.version = PNG_IMAGE_VERSION;
    ASSERT_NE(png_image_begin_read_from_file(&png, path.c_str()), 0) << png.message;
    EXPECT_EQ(png.width, image.width);
    EXPECT_EQ(png.height, image.height);
    EXPECT_EQ(png.format, static_cast<png_uint_32>(PNG_FORMAT_RGB));
    std::vector<std::uint8_t> rgb(PNG_IMAGE_SIZE(png));
    ASSERT_NE(png_image_finish_read(&png, nullptr, rgb.data(), 0, nullptr), 0) << png.message;
    EXPECT_EQ(rgb, image.rgb);
  }
  std::filesystem::remove(path);
}

TEST(WritePng, FaultsNameTheFile) {
  const Image image = sample_image(300, 300);
  const auto nowhere = write_png("/no/such/folder/picture.png", image);
  EXPECT_EQ(nowhere.code(), absl::StatusCode::kNotFound);
  EXPECT_THAT(std::string(nowhere.message()), testing::StartsWith("/no/such/folder/picture.png: cannot be opened"));
  EXPECT_EQ(write_png("picture.png", Image{}).code(), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(write_png("picture.png", Image{2, 2, {1, 2, 3}}).code(), absl::StatusCode::kInvalidArgument);
  if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "/dev/full is not there";
  const auto full = write_png("/dev/full", image);
  EXPECT_EQ(full.code(), absl::StatusCode::kUnavailable);
  EXPECT_THAT(std::string(full.message()), testing::HasSubstr("/dev/full: writing failed"));
}

TEST(EncodePng, HasTheBytesOfTheFile) {
  const std::string path = test::temporary_path("picture.png");
  for (const Image& image : {sample_image(1, 1), sample_image(320, 240)}) {
    ASSERT_TRUE(write_png(path, image).ok());
    std::ifstream file(path, std::ios::binary);
    const std::string expected{std::istreambuf_iterator<char>(file), {}};
    EXPECT_EQ(encode_png(image).value(), expected);
  }
  std::filesystem::remove(path);
  EXPECT_EQ(encode_png(Image{2, 2, {1, 2, 3}}).status().code(), absl::StatusCode::kInvalidArgument);
}

}  // namespace
}  // namespace segserve::picture
