// SPDX-License-Identifier: Apache-2.0
#include "core/codec/obj/obj_comments.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <string>
#include <system_error>

#include "core/base/status_macros.hpp"
#include "core/codec/common/field_roles.hpp"
#include "core/codec/common/limit_checks.hpp"
#include "core/codec/common/position_names.hpp"
#include "core/codec/common/text_parsing.hpp"

namespace segserve::codec {
namespace {

constexpr std::string_view kPaint = "#MRGB";
constexpr std::size_t kDigits = 8;

/// The words behind the sign in a comment such as "# File units = inches" or "# units: mm"; empty for other comments.
std::string_view unit_words(std::string_view line) {
  constexpr std::size_t kLongest = 80;
  const std::size_t sign = line.find_first_of("=:");
  if (line.size() > kLongest || sign == std::string_view::npos) return {};
  std::string_view name = line.substr(0, sign);
  std::string words;
  for (std::string_view word = take_word(name); !word.empty(); word = take_word(name)) words += lower_case(word);
  words.erase(0, words.find_first_not_of('#'));
  if (words != "fileunits" && words != "units" && words != "unit") return {};
  const std::string_view behind = line.substr(sign + 1);
  const std::size_t begin = behind.find_first_not_of(" \t");
  if (begin == std::string_view::npos) return {};
  return behind.substr(begin, behind.find_last_not_of(" \t") + 1 - begin);
}

/// The color in eight hexadecimal digits, with the mask above it.
std::optional<std::uint32_t> parse_paint(std::string_view digits) {
  std::uint32_t value = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value, 16);
  const bool is_whole = error == std::errc{} && end == digits.data() + digits.size() && digits.size() == kDigits;
  return is_whole ? std::optional(value & 0xFFFFFFU) : std::nullopt;
}

}  // namespace

absl::Status ObjComments::take(std::string_view line, const DecodeLimits& limits, StopCheck& check) {
  std::string_view rest = line;
  if (take_word(rest) != kPaint) {
    const std::string_view words = unit_words(line);
    if (words.empty()) return absl::OkStatus();
    const auto unit = unit_in_words(words);
    unit_ = unit ? ToldUnit{*unit, "as the file says"}
                 : ToldUnit{LengthUnit::kMeter, fmt::format("because the unit {} is not known", quoted(words)), true};
    return absl::OkStatus();
  }
  has_paint_ = true;
  for (std::string_view word = take_word(rest); !word.empty(); word = take_word(rest)) {
    const std::size_t colors = (word.size() + kDigits - 1) / kDigits;
    RETURN_IF_ERROR(check_points("OBJ file: #MRGB: ", paint_.size() + colors, limits));
    RETURN_IF_ERROR(check_decoded_points("OBJ file: #MRGB: ", paint_.size() + colors, sizeof paint_[0], limits));
    for (; !is_damaged_ && !word.empty(); word.remove_prefix(std::min(kDigits, word.size()))) {
      if (check.after(1)) return check.status();
      const auto color = parse_paint(word.substr(0, kDigits));
      is_damaged_ = !color;
      paint_.push_back(color.value_or(0));
    }
  }
  if (is_damaged_) paint_.clear();
  return absl::OkStatus();
}

}  // namespace segserve::codec
