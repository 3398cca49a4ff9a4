// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cmath>
#include <string>

#include "core/base/status_macros.hpp"
#include "core/codec/common/text_parsing.hpp"
#include "core/codec/rgbd/pnm_image.hpp"

namespace segserve::codec {
namespace {

/// The most bytes of a header with its comments.
constexpr std::size_t kMaxHeaderBytes = std::size_t{1} << 16U;

absl::Status fault(std::string_view message) {
  return absl::InvalidArgumentError(fmt::format("PGM, PPM or PFM: {}", message));
}

bool is_space(char c) { return c == ' ' || (c >= '\t' && c <= '\r'); }

/// Takes the words of a header. A comment reaches from # to the end of its line.
class HeaderWords {
 public:
  explicit HeaderWords(std::string_view bytes) : text_(bytes.substr(0, kMaxHeaderBytes)) {}

  /// Empty if the header ends too early.
  std::string_view next() {
    while (at_ < text_.size() && (is_space(text_[at_]) || text_[at_] == '#')) {
      if (text_[at_] == '#') {
        at_ = std::min(text_.size(), text_.find_first_of("\r\n", at_));
      } else {
        ++at_;
      }
    }
    const std::size_t begin = at_;
    while (at_ < text_.size() && !is_space(text_[at_]) && text_[at_] != '#') ++at_;
    return at_ < text_.size() ? text_.substr(begin, at_ - begin) : std::string_view();
  }
  /// The offset of what follows the single space or end of line after the last word.
  std::size_t offset_of_rest() const { return at_ + (text_.substr(at_).starts_with("\r\n") ? 2 : 1); }

 private:
  std::string_view text_;
  std::size_t at_ = 0;
};

std::optional<PnmKind> kind_of(std::string_view word) {
  if (word == "P2") return PnmKind::kGrayText;
  if (word == "P3") return PnmKind::kColorText;
  if (word == "P5") return PnmKind::kGray;
  if (word == "P6") return PnmKind::kColor;
  if (word == "Pf") return PnmKind::kFloat;
  return std::nullopt;
}

absl::StatusOr<std::uint32_t> side(std::string_view word) {
  constexpr std::uint64_t kMaxSide = 0x7fffffff;
  const auto number = parse_count(word);
  if (!number || *number == 0 || *number > kMaxSide) {
    return fault(fmt::format("{} is not the width or height of an image", quoted(word)));
  }
  return static_cast<std::uint32_t>(*number);
}

/// The largest value of integers, or the scale of floats, whose sign tells the order of their bytes.
absl::Status read_range(std::string_view word, PnmHeader& header) {
  if (header.kind == PnmKind::kFloat) {
    double scale = 0;
    if (!parse_scalar(word, ScalarType::kFloat64, reinterpret_cast<std::byte*>(&scale)) || !std::isfinite(scale) ||
        scale == 0) {
      return fault(fmt::format("{} is not the scale of a PFM", quoted(word)));
    }
    header.scale = std::abs(scale);
    header.order = scale < 0 ? std::endian::little : std::endian::big;
    return absl::OkStatus();
  }
  const auto most = parse_count(word);
  if (!most || *most == 0 || *most > UINT16_MAX) {
    return fault(fmt::format("{} is not a largest value from 1 to 65535", quoted(word)));
  }
  header.max_value = static_cast<std::uint32_t>(*most);
  return absl::OkStatus();
}

}  // namespace

bool is_pnm(std::string_view bytes) {
  return bytes.size() >= 3 && bytes[0] == 'P' && std::string_view("1234567Ff").find(bytes[1]) != bytes.npos &&
         (is_space(bytes[2]) || bytes[2] == '#');
}

absl::StatusOr<PnmHeader> read_pnm_header(std::string_view bytes) {
  HeaderWords words(bytes);
  const std::string_view magic = words.next();
  const auto kind = kind_of(magic);
  if (!kind) return fault(fmt::format("{} is not P2, P3, P5, P6 or Pf", quoted(magic)));
  PnmHeader header;
  header.kind = *kind;
  ASSIGN_OR_RETURN(header.size.width, side(words.next()));
  ASSIGN_OR_RETURN(header.size.height, side(words.next()));
  RETURN_IF_ERROR(read_range(words.next(), header));
  header.offset = words.offset_of_rest();
  return header;
}

}  // namespace segserve::codec
