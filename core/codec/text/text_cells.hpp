// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

namespace segserve::codec {

/// The separator between the cells of a line of text.
enum class Separator : std::uint8_t {
  kSpace,  ///< spaces and tabs, any number of them
  kComma,
  kSemicolon,
};

/// The separator of a line of numbers. Commas in words that spaces separate are decimal commas.
Separator separator_of(std::string_view line);

/// Takes the cells of a line one after the other, without the spaces and the quotation marks around them.
class CellReader {
 public:
  CellReader(std::string_view line, Separator separator) : rest_(line), separator_(separator) {}
  /// The next cell, which may be empty unless spaces separate; nullopt after the last one. A separator at the end of
  /// the line has no cell behind it.
  std::optional<std::string_view> next();

 private:
  std::string_view rest_;
  Separator separator_;
};

/// All cells of a line.
std::vector<std::string_view> split_cells(std::string_view line, Separator separator);

/// Parses a number; nullopt for other words.
std::optional<double> parse_number(std::string_view word);

/// Whether the word is a number with a decimal comma.
bool has_decimal_comma(std::string_view word);

}  // namespace segserve::codec
