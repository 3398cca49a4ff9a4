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

/// Walks over the lines of a text and counts them. Lines end in \n or \r\n, or in \r if the first one does.
class LineReader {
 public:
  explicit LineReader(std::string_view text, std::size_t first_line = 1) : text_(text), next_line_(first_line) {}

  struct Line {
    std::string_view text;    ///< without the end of line
    std::size_t number;       ///< counted from `first_line`
    bool terminated = false;  ///< false if the text ended before the end of line
  };
  /// The next line, or nullopt after the last one.
  std::optional<Line> next();
  /// Bytes consumed so far.
  std::size_t offset() const { return offset_; }

 private:
  std::string_view text_;
  std::size_t offset_ = 0;
  std::size_t next_line_;
  char end_ = '\0';  // the last character of each line; '\0' before the first one
};

/// The text without a byte order mark of UTF-8 at its beginning.
std::string_view without_byte_order_mark(std::string_view text);

/// The text without what is no text at its end: zeros of a file that was made too long, and the Control-Z of DOS.
std::string_view without_end_marks(std::string_view text);

/// The most values that a text of so many bytes can hold: each takes at least a digit and a delimiter, and the last one
/// needs no delimiter.
constexpr std::uint64_t most_values(std::uint64_t bytes) { return (bytes + 1) / 2; }

/// Whether the text consists of spaces, tabs and ends of line.
bool is_blank(std::string_view text);
/// Takes the next word off the front of `text`. Words are delimited by spaces, tabs and ends of line. Empty if no word
/// is left.
std::string_view take_word(std::string_view& text);
/// All words of `text`.
std::vector<std::string_view> split_words(std::string_view text);

/// Parses a number of decimal digits only; nullopt for other words, and for numbers beyond 64 bits.
std::optional<std::uint64_t> parse_count(std::string_view word);

/// Parses a number of the type, which may begin with a sign, and writes its `size_of(type)` bytes to `out`. Returns
/// false if `word` is no such number. An integer must fit the type, and has no decimals. A float may be nan or inf, in
/// Microsoft's spelling too (1.#QNAN, -1.#IND, 1.#INF), and have Fortran's exponent (1.5D-03); beyond the range of
/// kFloat32 it becomes 0 or infinite, and beyond the range of double it is refused. Every NaN becomes the same one,
/// since text does not keep its bits.
bool parse_scalar(std::string_view word, ScalarType type, std::byte* out);

/// Appends the shortest text that reads back as the same float. Every NaN becomes `nan`.
void append_number(std::string& out, float value);

/// Makes a word of untrusted bytes fit for a message: in quotes, at most 40 characters, and with '?' for each byte that
/// is not printable ASCII.
std::string quoted(std::string_view word);

/// Views bytes as text.
inline std::string_view as_text(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

}  // namespace segserve::codec
