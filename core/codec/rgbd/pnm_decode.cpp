// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <string>

#include "core/base/status_macros.hpp"
#include "core/codec/common/scalar_type.hpp"
#include "core/codec/common/text_parsing.hpp"
#include "core/codec/rgbd/pnm_image.hpp"

namespace segserve::codec {
namespace {

bool is_text(PnmKind kind) { return kind == PnmKind::kGrayText || kind == PnmKind::kColorText; }
bool is_color(PnmKind kind) { return kind == PnmKind::kColor || kind == PnmKind::kColorText; }

absl::Status fault(PnmKind kind, std::string_view message) {
  const char* name = kind == PnmKind::kFloat ? "PFM" : is_color(kind) ? "PPM" : "PGM";
  return absl::InvalidArgumentError(fmt::format("{}: {}", name, message));
}

/// The bytes of the image's numbers. INVALID_ARGUMENT unless they are there; in a text each takes at least two.
absl::StatusOr<std::string_view> raster_of(std::string_view bytes, const PnmHeader& header,
                                           std::uint64_t bytes_per_number, std::uint64_t numbers) {
  const std::string_view rest = bytes.substr(std::min(bytes.size(), header.offset));
  const std::uint64_t most = is_text(header.kind) ? most_values(rest.size()) : rest.size() / bytes_per_number;
  if (most >= numbers) return rest;
  return fault(header.kind, fmt::format("the bytes end too early: {} x {} pixels need {} numbers, but there are {} "
                                        "bytes",
                                        header.size.width, header.size.height, numbers, rest.size()));
}

/// Takes the next number of a text, in which comments may stand. `text` loses it.
std::optional<std::uint64_t> take_number(std::string_view& text) {
  std::string_view word = take_word(text);
  while (word.starts_with('#')) {
    // The comment reaches to the end of the line in which it begins.
    const char* begin = word.data();
    text = std::string_view(begin, static_cast<std::size_t>(text.data() + text.size() - begin));
    text.remove_prefix(std::min(text.size(), text.find_first_of("\r\n")));
    word = take_word(text);
  }
  return parse_count(word);
}

/// Calls take(i, value) for each of the integers.
template <typename Take>
absl::Status read_text(std::string_view raster, const PnmHeader& header, std::uint64_t numbers, StopCheck& check,
                       Take take) {
  bool sound = true;
  std::size_t read = 0;
  check.for_each(0, numbers, [&](std::size_t i) -> std::uint64_t {
    if (!sound) return 1;
    const std::size_t left = raster.size();
    const auto number = take_number(raster);
    sound = number && *number <= header.max_value;
    if (sound) take(i, static_cast<std::uint16_t>(*number));
    read += sound ? 1 : 0;
    return left - raster.size();
  });
  RETURN_IF_ERROR(check.status());
  if (sound) return absl::OkStatus();
  return fault(header.kind, fmt::format("number {} of {} is missing, or is no integer from 0 to {}", read + 1, numbers,
                                        header.max_value));
}

/// Calls take(i, value) for each of the integers. INVALID_ARGUMENT if one is above the largest value.
template <typename Number, typename Take>
absl::Status read_bytes(std::string_view raster, const PnmHeader& header, std::uint64_t numbers, StopCheck& check,
                        Take take) {
  const auto* bytes = reinterpret_cast<const std::byte*>(raster.data());
  bool sound = true;
  check.for_each(0, numbers, [&](std::size_t i) {
    const auto number = load<Number>(bytes + i * sizeof(Number), std::endian::big);
    sound = sound && number <= header.max_value;
    take(i, number);
  });
  RETURN_IF_ERROR(check.status());
  if (sound) return absl::OkStatus();
  return fault(header.kind,
               fmt::format("a number is above {}, the largest value that its header allows", header.max_value));
}

/// Allocates by `reserve` once the bytes are known to be there, and calls take(i, value) for each of the integers.
template <typename Reserve, typename Take>
absl::Status read_integers(std::string_view bytes, const PnmHeader& header, StopCheck& check, Reserve reserve,
                           Take take) {
  const std::uint64_t numbers = header.size.pixels() * (is_color(header.kind) ? 3 : 1);
  const bool wide = header.max_value > UINT8_MAX;
  ASSIGN_OR_RETURN(const std::string_view raster, raster_of(bytes, header, wide ? 2 : 1, numbers));
  reserve(numbers);
  if (is_text(header.kind)) return read_text(raster, header, numbers, check, take);
  if (wide) return read_bytes<std::uint16_t>(raster, header, numbers, check, take);
  return read_bytes<std::uint8_t>(raster, header, numbers, check, take);
}

}  // namespace

absl::StatusOr<GrayImage> decode_pgm_depth(std::string_view bytes, const DecodeLimits& limits, StopCheck& check) {
  ASSIGN_OR_RETURN(const PnmHeader header, read_pnm_header(bytes));
  if (is_color(header.kind)) {
    return fault(header.kind, "it is a color image, but depth must be gray; are depth and color interchanged?");
  }
  if (header.kind == PnmKind::kFloat) return fault(header.kind, "it holds floats, not integers");
  if (header.max_value <= UINT8_MAX) {
    return fault(header.kind, fmt::format("its largest value is {}, but depth needs 16 bits: this is a picture of a "
                                          "depth image, which has lost the distances; write the depth itself, with a "
                                          "largest value of 65535",
                                          header.max_value));
  }
  RETURN_IF_ERROR(check_image_size(header.size, sizeof(std::uint16_t), limits));
  GrayImage image{header.size, {}};
  RETURN_IF_ERROR(read_integers(
      bytes, header, check, [&](std::uint64_t numbers) { image.pixels.resize(numbers); },
      [&](std::size_t i, std::uint16_t value) { image.pixels[i] = value; }));
  return image;
}

absl::StatusOr<FloatImage> decode_pfm(std::string_view bytes, const DecodeLimits& limits, StopCheck& check) {
  ASSIGN_OR_RETURN(const PnmHeader header, read_pnm_header(bytes));
  if (header.kind != PnmKind::kFloat) return fault(header.kind, "it is no gray PFM, which begins with Pf");
  const auto [width, height] = header.size;
  RETURN_IF_ERROR(check_image_size(header.size, sizeof(float), limits));
  ASSIGN_OR_RETURN(const std::string_view raster, raster_of(bytes, header, sizeof(float), header.size.pixels()));
  FloatImage image{header.size, std::vector<float>(header.size.pixels())};
  const auto* from = reinterpret_cast<const std::byte*>(raster.data());
  for (std::uint32_t row = height; row-- > 0 && !check.after(width);) {
    float* to = image.pixels.data() + std::size_t{row} * width;
    for (std::uint32_t i = 0; i < width; ++i, from += sizeof(float)) to[i] = load<float>(from, header.order);
  }
  RETURN_IF_ERROR(check.status());
  return image;
}

absl::StatusOr<ColorImage> decode_pnm_color(std::string_view bytes, const DecodeLimits& limits, StopCheck& check) {
  ASSIGN_OR_RETURN(const PnmHeader header, read_pnm_header(bytes));
  if (header.kind == PnmKind::kFloat) return fault(header.kind, "it holds floats, but colors must be integers");
  RETURN_IF_ERROR(check_image_size(header.size, 3, limits));
  ColorImage image{header.size, {}};
  const std::size_t repeated = is_color(header.kind) ? 1 : 3;
  RETURN_IF_ERROR(read_integers(
      bytes, header, check, [&](std::uint64_t numbers) { image.rgb.resize(repeated * numbers); },
      [&](std::size_t i, std::uint32_t value) {
        const std::uint32_t level = (UINT8_MAX * value + header.max_value / 2) / header.max_value;
        std::fill_n(image.rgb.begin() + static_cast<std::ptrdiff_t>(repeated * i), repeated,
                    static_cast<std::uint8_t>(level));
      }));
  return image;
}

}  // namespace segserve::codec
