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

}  // namespace

absl::Status write_png(const std::string& path, const Image& image) {
  if (image.rgb.empty() || image.rgb.size() != std::size_t{3} * image.width * image.height) {
    return absl::InvalidArgumentError(fmt::format("{}: a picture of {} x {} pixels with {} bytes cannot be written",
                                                  path, image.width, image.height, image.rgb.size()));
  }
  const std::unique_ptr<std::FILE, CloseFile> file(path == "-" ? stdout : std::fopen(path.c_str(), "wb"));
  if (!file) return absl::ErrnoToStatus(errno, path + ": cannot be opened");
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  png.width = image.width;
  png.height = image.height;
  png.format = PNG_FORMAT_RGB;
  if (png_image_write_to_stdio(&png, file.get(), 0, image.rgb.data(), 0, nullptr) == 0) {
    return absl::UnavailableError(fmt::format("{}: writing failed: {}", path, png.message));
  }
  if (std::fflush(file.get()) != 0) {
    return absl::UnavailableError(fmt::format("{}: writing failed: {}", path, std::strerror(errno)));
  }
  return absl::OkStatus();
}

}  // namespace segserve::picture
