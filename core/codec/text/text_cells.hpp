// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

namespace segserve::codec {

/// The separator between the cells of a line of text.
enum class Separator : std::uint8_t {
  kSpace,  ///< spaces and tabs, any number of them
  kTab,    ///< each tab, so that cells may be empty or have spaces in them
  kComma,
  kSemicolon,
  kBar,  ///< |
};

/// The separator of a line of numbers. Commas in words that spaces separate are decimal commas. Tabs are taken as
/// spaces.
Separator separator_of(std::string_view line);

/// Takes the cells of a line one after the other, without the spaces and the quotation marks around them.
class CellReader {
 public:
  CellReader(std::string_view line, Separator separator) : rest_(line), separator_(separator) {}
  /// The next cell, which may be empty unless spaces separate; nullopt after the last one. A separator at the end of
  /// the line has no cell behind it.
  std::optional<std::string_view> next();
  /// Whether a separator stands behind the last cell. It may be the cell before one that is empty.
  bool ended_with_separator() const { return ended_with_separator_; }

 private:
  std::string_view rest_;
  Separator separator_;
  bool ended_with_separator_ = false;
};

/// The cells of a line, `most` at most.
std::vector<std::string_view> split_cells(std::string_view line, Separator separator,
                                          std::size_t most = static_cast<std::size_t>(-1));

/// Parses a number; nullopt for other words.
std::optional<double> parse_number(std::string_view word);

/// Parses the number of a cell, which may have a decimal comma unless commas separate. What stands for an unknown
/// number, such as nothing, NA or null, is NaN. nullopt for other words.
std::optional<double> parse_cell(std::string_view cell, Separator separator);

/// Whether the word is a number with a decimal comma.
bool has_decimal_comma(std::string_view word);

}  // namespace segserve::codec
