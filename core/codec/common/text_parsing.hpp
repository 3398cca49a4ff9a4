// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/codec/common/scalar_type.hpp"

namespace segserve::codec {

/// Walks over the lines of a text and counts them. Lines end in \n or \r\n.
class LineReader {
 public:
  explicit LineReader(std::string_view text, std::size_t first_line = 1) : text_(text), next_line_(first_line) {}

  struct Line {
    std::string_view text;    ///< without the end of line
    std::size_t number;       ///< from 1
    bool terminated = false;  ///< false: the text ended before the end of line
  };
  std::optional<Line> next();
  /// Bytes consumed so far.
  std::size_t offset() const { return offset_; }

 private:
  std::string_view text_;
  std::size_t offset_ = 0;
  std::size_t next_line_;
};

/// Takes the next word, delimited by spaces, tabs or ends of line, off the front; empty: none left.
std::string_view take_word(std::string_view& text);
std::vector<std::string_view> split_words(std::string_view text);

/// Decimal digits only, and no overflow.
std::optional<std::uint64_t> parse_count(std::string_view word);

/// Writes the number's `size_of(type)` bytes to `out`; false if `word` is not a number of the type.
/// A float may be nan, inf or out of range (then it is 0 or infinite); an integer must fit.
bool parse_scalar(std::string_view word, ScalarType type, std::byte* out);

/// Appends the shortest text that reads back as the same float; every NaN is `nan`.
void append_number(std::string& out, float value);

/// A word of untrusted bytes for a message: in quotes, shortened, unprintable bytes as '?'.
std::string quoted(std::string_view word);

inline std::string_view as_text(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

}  // namespace segserve::codec
