// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <array>
#include <csetjmp>
#include <cstdio>
#include <cstdlib>
#include <vector>

// jpeglib.h needs what stands above.
#include <jpeglib.h>

#include "core/codec/rgbd/jpeg_image.hpp"

namespace segserve::codec {
namespace {

absl::Status fault(std::string_view message) { return absl::InvalidArgumentError(fmt::format("JPEG: {}", message)); }

/// The bytes that an image of 4:2:0 hardly ever exceeds: headers, and two bytes for each number of whole blocks.
std::size_t usual_bytes(const ImageSize& size) {
  constexpr std::size_t kBlock = 16, kHeaderBytes = 2048, kPixelBytes = 3;
  const auto padded = [](std::size_t side) { return (side + kBlock - 1) / kBlock * kBlock; };
  return kHeaderBytes + kPixelBytes * padded(size.width) * padded(size.height);
}

/// libjpeg's state. It reports errors by a jump over stack frames: nothing between its functions and setjmp may have a
/// destructor.
struct Encoder {
  jpeg_compress_struct jpeg{};
  jpeg_error_mgr errors{};
  std::jmp_buf jump{};
  std::array<char, JMSG_LENGTH_MAX> error{};

  Encoder() {
    jpeg.err = jpeg_std_error(&errors);
    jpeg.client_data = this;
    errors.error_exit = [](j_common_ptr common) {
      auto& self = *static_cast<Encoder*>(common->client_data);
      self.errors.format_message(common, self.error.data());
      std::longjmp(self.jump, 1);  // NOLINT(cert-err52-cpp)
    };
    errors.output_message = [](j_common_ptr) {};
  }
  ~Encoder() { jpeg_destroy_compress(&jpeg); }
  Encoder(const Encoder&) = delete;
  Encoder& operator=(const Encoder&) = delete;

  /// Writes to `bytes`, which has space for `size`, or to memory of malloc if that is too small. Sets both to what was
  /// written. Returns false, with `error` set, if that fails.
  bool encode(const ImageSize& image, const std::uint8_t* rgb, int quality, unsigned char*& bytes,
              unsigned long& size) {
    if (setjmp(jump) != 0) return false;  // NOLINT(cert-err52-cpp): libjpeg reports errors so.
    jpeg_create_compress(&jpeg);
    jpeg_mem_dest(&jpeg, &bytes, &size);
    jpeg.image_width = image.width;
    jpeg.image_height = image.height;
    jpeg.input_components = 3;
    jpeg.in_color_space = JCS_RGB;
    jpeg_set_defaults(&jpeg);  // among others 4:2:0
    jpeg.dct_method = JDCT_ISLOW;
    jpeg_set_quality(&jpeg, quality, TRUE);
    jpeg_start_compress(&jpeg, TRUE);
    const std::size_t row_bytes = std::size_t{3} * image.width;
    while (jpeg.next_scanline < jpeg.image_height) {
      auto* row = const_cast<JSAMPROW>(rgb + jpeg.next_scanline * row_bytes);
      jpeg_write_scanlines(&jpeg, &row, 1);
    }
    jpeg_finish_compress(&jpeg);
    return true;
  }
};

}  // namespace

absl::StatusOr<std::string> encode_jpeg(const ColorImage& image, int quality) {
  if (quality < 1 || quality > 100) return fault(fmt::format("a quality of {} is not in [1, 100]", quality));
  constexpr std::uint32_t kMaxSide = 65535;
  if (image.size.width > kMaxSide || image.size.height > kMaxSide || image.size.pixels() == 0) {
    return fault(fmt::format("the image has {} x {} pixels, but each side must have 1 to {}", image.size.width,
                             image.size.height, kMaxSide));
  }
  std::vector<unsigned char> buffer(usual_bytes(image.size));
  unsigned char* bytes = buffer.data();
  unsigned long size = buffer.size();
  Encoder encoder;
  if (!encoder.encode(image.size, image.rgb.data(), quality, bytes, size)) {
    return absl::InternalError(fmt::format("JPEG: {}", encoder.error.data()));
  }
  std::string file(reinterpret_cast<const char*>(bytes), size);
  if (bytes != buffer.data()) std::free(bytes);
  return file;
}

}  // namespace segserve::codec
