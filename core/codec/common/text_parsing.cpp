// SPDX-License-Identifier: Apache-2.0
#include "core/codec/common/text_parsing.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <iterator>
#include <limits>
#include <system_error>

namespace segserve::codec {
namespace {

bool is_space(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n'; }

/// Converts the number at the beginning of the word.
template <typename T>
std::from_chars_result convert(std::string_view word, T& value) {
  return std::from_chars(word.data(), word.data() + word.size(), value);
}

/// Converts the whole word. A number beyond the range of float is converted as a double first, and then becomes 0 or
/// infinite.
template <typename T>
bool convert_float(std::string_view word, T& value) {
  auto result = convert(word, value);
  if (result.ec == std::errc::result_out_of_range) {
    double wide = 0.0;
    result = convert(word, wide);
    value = static_cast<T>(wide);
  }
  return result.ec == std::errc{} && result.ptr == word.data() + word.size();
}

/// Converts a number whose exponent has the letter of Fortran's double precision, as in 1.5D-03.
template <typename T>
bool convert_fortran(std::string_view word, T& value) {
  std::array<char, 40> copy;
  const std::size_t letter = word.find_first_of("Dd");
  if (letter == std::string_view::npos || letter == 0 || letter + 1 >= word.size() || word.size() > copy.size()) {
    return false;
  }
  const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
  if ((!is_digit(word[letter - 1]) && word[letter - 1] != '.') || !is_digit(word.back())) return false;
  std::ranges::copy(word, copy.begin());
  copy[letter] = 'e';
  return convert_float(std::string_view(copy.data(), word.size()), value);
}

/// The character that ends the lines of the text: \r if that ends the first one alone, else \n.
char line_end(std::string_view text) {
  const std::size_t first = text.find_first_of("\r\n");
  const bool is_alone = first != std::string_view::npos && text[first] == '\r' && text.substr(first + 1, 1) != "\n";
  return is_alone ? '\r' : '\n';
}

/// The number that Microsoft's C library writes as 1.#QNAN, 1.#SNAN, 1.#IND or 1.#INF, also with zeros behind it. With
/// few decimals it rounds the letters as if they were digits, so that NaN becomes 1.#R, 1.#J or 1.#IO.
template <typename T>
std::optional<T> microsoft_number(std::string_view word) {
  const bool is_negative = word.starts_with('-');
  if (is_negative) word.remove_prefix(1);
  if (!word.starts_with("1.#")) return std::nullopt;
  word.remove_prefix(3);
  if (!word.starts_with("INF")) {
    constexpr std::string_view kRounded = "IJQRS";  // how the words for NaN begin, as numbers rounded to a few decimals
    const bool is_nan = !word.empty() && kRounded.find(word[0]) != std::string_view::npos;
    return is_nan ? std::optional(std::numeric_limits<T>::quiet_NaN()) : std::nullopt;
  }
  return is_negative ? -std::numeric_limits<T>::infinity() : std::numeric_limits<T>::infinity();
}

}  // namespace

std::string_view without_byte_order_mark(std::string_view text) {
  constexpr std::string_view kMark = "\xEF\xBB\xBF";
  if (text.starts_with(kMark)) text.remove_prefix(kMark.size());
  return text;
}

std::string_view without_end_marks(std::string_view text) {
  while (!text.empty() && (text.back() == '\0' || text.back() == '\x1a')) text.remove_suffix(1);
  return text;
}

std::optional<LineReader::Line> LineReader::next() {
  if (offset_ >= text_.size()) return std::nullopt;
  const std::string_view rest = text_.substr(offset_);
  if (end_ == '\0') end_ = line_end(rest);
  const std::size_t end = rest.find(end_);
  const bool terminated = end != std::string_view::npos;
  std::string_view line = rest.substr(0, end);
  offset_ += terminated ? end + 1 : rest.size();
  if (line.ends_with('\r')) line.remove_suffix(1);
  return Line{line, next_line_++, terminated};
}

bool is_blank(std::string_view text) { return std::all_of(text.begin(), text.end(), is_space); }

std::string_view take_word(std::string_view& text) {
  std::size_t begin = 0;
  while (begin < text.size() && is_space(text[begin])) ++begin;
  std::size_t end = begin;
  while (end < text.size() && !is_space(text[end])) ++end;
  const std::string_view word = text.substr(begin, end - begin);
  text.remove_prefix(end);
  return word;
}

std::vector<std::string_view> split_words(std::string_view text) {
  std::vector<std::string_view> words;
  for (std::string_view word = take_word(text); !word.empty(); word = take_word(text)) words.push_back(word);
  return words;
}

std::optional<std::uint64_t> parse_count(std::string_view word) {
  std::uint64_t value = 0;
  const auto [end, error] = convert(word, value);
  if (error != std::errc{} || end != word.data() + word.size()) return std::nullopt;
  return value;
}

bool parse_scalar(std::string_view word, ScalarType type, std::byte* out) {
  if (word.starts_with('+') && !word.starts_with("+-")) word.remove_prefix(1);  // std::from_chars refuses a '+'.
  return visit_type(type, [&]<typename T>(T value) {
    if constexpr (std::is_floating_point_v<T>) {
      if (const auto number = microsoft_number<T>(word)) {
        value = *number;
      } else if (!convert_float(word, value) && !convert_fortran(word, value)) {
        return false;
      } else if (std::isnan(value)) {
        value = std::numeric_limits<T>::quiet_NaN();
      }
    } else {
      const auto [end, error] = convert(word, value);
      if (error != std::errc{} || end != word.data() + word.size()) return false;
    }
    std::memcpy(out, &value, sizeof(T));
    return true;
  });
}

void append_number(std::string& out, float value) {
  if (std::isnan(value)) {
    out += "nan";
  } else {
    fmt::format_to(std::back_inserter(out), "{}", value);
  }
}

std::string quoted(std::string_view word) {
  constexpr std::size_t kLongest = 40;
  std::string text = "'";
  for (const char c : word.substr(0, kLongest)) text += c >= ' ' && c <= '~' ? c : '?';
  text += word.size() > kLongest ? "...'" : "'";
  return text;
}

}  // namespace segserve::codec
