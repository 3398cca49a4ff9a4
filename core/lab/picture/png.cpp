// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <png.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <memory>

#include "core/lab/picture/picture.hpp"

namespace segserve::picture {
namespace {

struct CloseFile {
  void operator()(std::FILE* file) const {
    if (file != stdout) std::fclose(file);
  }
};

bool has_pixels(const Image& image) {
  return !image.rgb.empty() && image.rgb.size() == std::size_t{3} * image.width * image.height;
}

png_image png_of(const Image& image) {
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  png.width = image.width;
  png.height = image.height;
  png.format = PNG_FORMAT_RGB;
  return png;
}

}  // namespace

absl::Status write_png(const std::string& path, const Image& image) {
  if (!has_pixels(image)) {
    return absl::InvalidArgumentError(fmt::format("{}: a picture of {} x {} pixels with {} bytes cannot be written",
                                                  path, image.width, image.height, image.rgb.size()));
  }
  const std::unique_ptr<std::FILE, CloseFile> file(path == "-" ? stdout : std::fopen(path.c_str(), "wb"));
  if (!file) return absl::ErrnoToStatus(errno, path + ": cannot be opened");
  png_image png = png_of(image);
  if (png_image_write_to_stdio(&png, file.get(), 0, image.rgb.data(), 0, nullptr) == 0) {
    return absl::UnavailableError(fmt::format("{}: writing failed: {}", path, png.message));
  }
  if (std::fflush(file.get()) != 0) {
    return absl::UnavailableError(fmt::format("{}: writing failed: {}", path, std::strerror(errno)));
  }
  return absl::OkStatus();
}

absl::StatusOr<std::string> encode_png(const Image& image) {
  if (!has_pixels(image)) {
    return absl::InvalidArgumentError(fmt::format("a picture of {} x {} pixels with {} bytes cannot be encoded",
                                                  image.width, image.height, image.rgb.size()));
  }
  png_image png = png_of(image);
  std::string bytes(PNG_IMAGE_PNG_SIZE_MAX(png), '\0');
  png_alloc_size_t size = bytes.size();
  if (png_image_write_to_memory(&png, bytes.data(), &size, 0, image.rgb.data(), 0, nullptr) == 0) {
    return absl::UnavailableError(fmt::format("encoding a picture failed: {}", png.message));
  }
  bytes.resize(size);
  return bytes;
}

}  // namespace segserve::picture
