// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <csetjmp>
#include <cstdio>
#include <optional>
#include <vector>

// jpeglib.h needs what stands above.
#include <jerror.h>
#include <jpeglib.h>

#include "core/base/status_macros.hpp"
#include "core/codec/common/limit_checks.hpp"
#include "core/codec/rgbd/jpeg_image.hpp"

namespace segserve::codec {
namespace {

/// Cameras and programs write about ten scans. Each scan of a hostile file costs the time of a whole image.
constexpr int kMaxScans = 100;

absl::Status fault(std::string_view message) { return absl::InvalidArgumentError(fmt::format("JPEG: {}", message)); }

/// libjpeg's state, and that of its callbacks. It reports errors by jumps over stack frames: nothing between a callback
/// and setjmp may have a destructor.
class Decoder {
 public:
  Decoder(std::string_view bytes, StopCheck& check) : check_(check) {
    jpeg_.err = jpeg_std_error(&errors_);
    errors_.error_exit = [](j_common_ptr jpeg) { of(jpeg).leave(); };
    errors_.emit_message = [](j_common_ptr jpeg, int level) { of(jpeg).take_message(level); };
    progress_.progress_monitor = [](j_common_ptr jpeg) { of(jpeg).look_at_progress(); };
    jpeg_.client_data = this;
    bytes_ = bytes;
  }
  ~Decoder() { jpeg_destroy_decompress(&jpeg_); }
  Decoder(const Decoder&) = delete;
  Decoder& operator=(const Decoder&) = delete;

  /// Reads what stands before the pixels. Returns false, with `error` set, if that fails.
  bool read_header() {
    if (setjmp(jump_) != 0) return false;  // NOLINT(cert-err52-cpp): libjpeg reports errors so.
    jpeg_create_decompress(&jpeg_);
    jpeg_.progress = &progress_;
    jpeg_mem_src(&jpeg_, reinterpret_cast<const unsigned char*>(bytes_.data()), bytes_.size());
    jpeg_read_header(&jpeg_, TRUE);
    return true;
  }

  ImageSize size() const { return {jpeg_.image_width, jpeg_.image_height}; }
  bool has_ink() const { return jpeg_.num_components == 4; }
  bool saw_adobe() const { return jpeg_.saw_Adobe_marker != 0; }

  /// The most memory that the library takes for coefficients: numbers of 16 bits, in whole blocks of all components.
  std::uint64_t coefficient_bytes() {
    if (jpeg_has_multiple_scans(&jpeg_) == 0) return 0;
    const auto padded = [](std::uint64_t side, int sampling) {
      const std::uint64_t block = std::uint64_t{DCTSIZE} * static_cast<unsigned>(std::max(sampling, 1));
      return (side + block - 1) / block * block;
    };
    const auto components = static_cast<std::uint64_t>(jpeg_.num_components);
    return padded(jpeg_.image_width, most_sampling(&jpeg_component_info::h_samp_factor)) *
           padded(jpeg_.image_height, most_sampling(&jpeg_component_info::v_samp_factor)) * components * sizeof(JCOEF);
  }

  /// Decodes into rows of 3 bytes a pixel. An image with ink needs a row of 4 bytes a pixel besides. Returns false,
  /// with `error` set, if that fails, or if it was stopped.
  bool decode(std::uint8_t* rgb, std::uint8_t* ink_row) {
    if (setjmp(jump_) != 0) return false;  // NOLINT(cert-err52-cpp): libjpeg reports errors so.
    jpeg_.dct_method = JDCT_ISLOW;
    jpeg_.out_color_space = has_ink() ? JCS_CMYK : JCS_RGB;
    jpeg_start_decompress(&jpeg_);
    const std::size_t row_bytes = std::size_t{3} * jpeg_.output_width;
    while (jpeg_.output_scanline < jpeg_.output_height) {
      std::uint8_t* row = rgb + jpeg_.output_scanline * row_bytes;
      JSAMPROW target = has_ink() ? ink_row : row;
      jpeg_read_scanlines(&jpeg_, &target, 1);
      if (has_ink()) mix(ink_row, row);
    }
    jpeg_finish_decompress(&jpeg_);
    return true;
  }

  const char* error() const { return error_.data(); }
  /// Whether the bytes end before the first row of blocks.
  bool nothing_decoded() const { return ended_ && lost_row_ == 0U && !details_lost_; }
  std::string damage() const;

 private:
  static Decoder& of(j_common_ptr jpeg) { return *static_cast<Decoder*>(jpeg->client_data); }

  int most_sampling(int jpeg_component_info::*factor) const {
    int most = 1;
    for (int i = 0; i < jpeg_.num_components; ++i) most = std::max(most, jpeg_.comp_info[i].*factor);
    return most;
  }

  [[noreturn]] void leave() {
    errors_.format_message(reinterpret_cast<j_common_ptr>(&jpeg_), error_.data());
    std::longjmp(jump_, 1);  // NOLINT(cert-err52-cpp)
  }

  void look_at_progress() {
    if (jpeg_.input_scan_number > kMaxScans) {
      *fmt::format_to_n(error_.data(), error_.size() - 1, "it has more than {} scans", kMaxScans).out = '\0';
      std::longjmp(jump_, 1);  // NOLINT(cert-err52-cpp)
    }
    // It is called for each row of blocks in each scan, and for each row of pixels.
    if (check_.after(std::uint64_t{jpeg_.image_width} * DCTSIZE)) std::longjmp(jump_, 1);  // NOLINT(cert-err52-cpp)
  }

  /// Keeps the first warning that says that pixels are lost, or else the first one.
  void take_message(int level) {
    // The library has a message of a level above 0 for each marker, of which there may be millions before the pixels.
    constexpr std::uint64_t kMarkerUnits = 16;
    if (level > 0 && check_.after(kMarkerUnits)) std::longjmp(jump_, 1);  // NOLINT(cert-err52-cpp)
    const int code = errors_.msg_code;
    if (level >= 0 || code == JWRN_JFIF_MAJOR || code == JWRN_ADOBE_XFORM) return;
    ended_ = ended_ || code == JWRN_JPEG_EOF;
    const bool loses_pixels = code != JWRN_JPEG_EOF && code != JWRN_EXTRANEOUS_DATA && code != JWRN_TOO_MUCH_DATA;
    if (warned_ && (lost_row_ || !loses_pixels)) return;
    warned_ = true;
    errors_.format_message(reinterpret_cast<j_common_ptr>(&jpeg_), message_.data());
    if (!loses_pixels) return;
    lost_row_ = jpeg_.input_iMCU_row * static_cast<unsigned>(jpeg_.max_v_samp_factor) * DCTSIZE;
    details_lost_ = jpeg_.input_scan_number > 1;
  }

  /// Turns a row of cyan, magenta, yellow and black into red, green and blue. Files with Adobe's marker store how much
  /// of each color is left, the others how much ink there is.
  void mix(const std::uint8_t* ink, std::uint8_t* rgb) const {
    const auto left = [adobe = saw_adobe()](std::uint8_t value) { return adobe ? value : 255 - value; };
    for (JDIMENSION i = 0; i < jpeg_.output_width; ++i, ink += 4, rgb += 3) {
      const int black = left(ink[3]);
      for (int c = 0; c < 3; ++c) rgb[c] = static_cast<std::uint8_t>((left(ink[c]) * black + 127) / 255);
    }
  }

  jpeg_decompress_struct jpeg_{};
  jpeg_error_mgr errors_{};
  jpeg_progress_mgr progress_{};
  std::jmp_buf jump_{};
  std::string_view bytes_;
  StopCheck& check_;
  std::array<char, JMSG_LENGTH_MAX> error_{};    // of the error that ended decoding
  std::array<char, JMSG_LENGTH_MAX> message_{};  // of a warning
  bool warned_ = false;
  bool ended_ = false;                     // whether the bytes ended before the end marker
  std::optional<std::uint32_t> lost_row_;  // the first row of pixels that is lost
  bool details_lost_ = false;              // whether an earlier scan holds all rows in a coarser form
};

std::string Decoder::damage() const {
  if (!warned_) return "";
  if (!lost_row_) return fmt::format("{}; all pixels are there", message_.data());
  if (details_lost_) return fmt::format("{}; its pixels are coarser than they were", message_.data());
  return fmt::format("{}; from row {} of {} on its pixels are lost or wrong", message_.data(), *lost_row_,
                     jpeg_.image_height);
}

}  // namespace

bool is_jpeg(std::string_view bytes) { return bytes.starts_with("\xff\xd8\xff"); }

absl::StatusOr<JpegImage> decode_jpeg(std::string_view bytes, const DecodeLimits& limits, StopCheck& check) {
  if (!is_jpeg(bytes)) return fault("the bytes do not begin with a JPEG signature");
  Decoder decoder(bytes, check);
  if (!decoder.read_header()) {
    RETURN_IF_ERROR(check.status());
    return fault(decoder.error());
  }
  JpegImage result;
  result.image.size = decoder.size();
  constexpr std::size_t kPixelBytes = 3;
  RETURN_IF_ERROR(check_image_size(result.image.size, kPixelBytes, limits));
  const std::uint64_t pixel_bytes = kPixelBytes * result.image.size.pixels();
  RETURN_IF_ERROR(check_bytes("JPEG: ", pixel_bytes + decoder.coefficient_bytes(), limits));
  result.image.rgb.resize(pixel_bytes);
  std::vector<std::uint8_t> ink_row(decoder.has_ink() ? std::size_t{4} * result.image.size.width : 0);
  const bool decoded = decoder.decode(result.image.rgb.data(), ink_row.data());
  RETURN_IF_ERROR(check.status());
  if (!decoded) return fault(decoder.error());
  if (decoder.nothing_decoded()) return fault("the bytes end before the first row of pixels");
  result.damage = decoder.damage();
  return result;
}

}  // namespace segserve::codec
