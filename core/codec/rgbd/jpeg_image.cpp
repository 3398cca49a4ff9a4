// SPDX-License-Identifier: Apache-2.0
#include "core/codec/rgbd/jpeg_image.hpp"

#include <fmt/format.h>
#include <turbojpeg.h>

#include <memory>

#include "core/base/status_macros.hpp"

namespace segserve::codec {
namespace {

/// Destroys a decoder or encoder.
struct Destroy {
  void operator()(void* handle) const { tjDestroy(handle); }
};
using Handle = std::unique_ptr<void, Destroy>;

/// Frees bytes that an encoder has allocated.
struct Free {
  void operator()(unsigned char* bytes) const { tjFree(bytes); }
};

absl::Status fault(std::string_view message) { return absl::InvalidArgumentError(fmt::format("JPEG: {}", message)); }

}  // namespace

bool is_jpeg(std::string_view bytes) { return bytes.starts_with("\xff\xd8\xff"); }

absl::StatusOr<ColorImage> decode_jpeg(std::string_view bytes, const DecodeLimits& limits) {
  if (!is_jpeg(bytes)) return fault("the bytes do not begin with a JPEG signature");
  const Handle decoder(tjInitDecompress());
  if (!decoder) return absl::InternalError("JPEG: the decoder cannot be made");
  const auto* data = reinterpret_cast<const unsigned char*>(bytes.data());
  int width = 0;
  int height = 0;
  int subsampling = 0;
  int color_space = 0;
  if (tjDecompressHeader3(decoder.get(), data, bytes.size(), &width, &height, &subsampling, &color_space) != 0) {
    return fault(tjGetErrorStr2(decoder.get()));
  }
  ColorImage image;
  image.size = {static_cast<std::uint32_t>(width), static_cast<std::uint32_t>(height)};
  // A pixel takes 3 bytes, and in a progressive image, whose coefficients are kept, 3 numbers of 16 bits as well.
  constexpr std::size_t kPixelBytes = 9;
  RETURN_IF_ERROR(check_image_size(image.size, kPixelBytes, limits));
  image.rgb.resize(3 * image.size.pixels());
  constexpr int kFlags = TJFLAG_ACCURATEDCT | TJFLAG_STOPONWARNING | TJFLAG_LIMITSCANS;
  if (tjDecompress2(decoder.get(), data, bytes.size(), image.rgb.data(), width, 3 * width, height, TJPF_RGB, kFlags) !=
      0) {
    return fault(tjGetErrorStr2(decoder.get()));
  }
  return image;
}

absl::StatusOr<std::string> encode_jpeg(const ColorImage& image, int quality) {
  if (quality < 1 || quality > 100) return fault(fmt::format("a quality of {} is not in [1, 100]", quality));
  constexpr std::uint32_t kMaxSide = 65535;
  if (image.size.width > kMaxSide || image.size.height > kMaxSide || image.size.pixels() == 0) {
    return fault(fmt::format("the image has {} x {} pixels, but each side must have 1 to {}", image.size.width,
                             image.size.height, kMaxSide));
  }
  const Handle encoder(tjInitCompress());
  if (!encoder) return absl::InternalError("JPEG: the encoder cannot be made");
  unsigned char* bytes = nullptr;
  unsigned long size = 0;
  const int width = static_cast<int>(image.size.width);
  const int failed = tjCompress2(encoder.get(), image.rgb.data(), width, 3 * width, static_cast<int>(image.size.height),
                                 TJPF_RGB, &bytes, &size, TJSAMP_420, quality, TJFLAG_ACCURATEDCT);
  const std::unique_ptr<unsigned char, Free> owner(bytes);
  if (failed != 0) return absl::InternalError(fmt::format("JPEG: {}", tjGetErrorStr2(encoder.get())));
  return std::string(reinterpret_cast<const char*>(bytes), size);
}

}  // namespace segserve::codec
