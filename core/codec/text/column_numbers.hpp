// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace segserve::codec {

/// Which columns a line of their numbers is for.
struct ColumnNumbers {
  std::string first, last;  ///< the first and the last of them, as "0" and "5" or "V1" and "V6"
  std::size_t count = 0;
  bool has_row_numbers = false;  ///< an empty cell stands before them
};

/// Whether a line has names that programs make up: 0,1,2 and so on, as pandas writes them, V1,V2,V3 as R does, or
/// Var1,Var2,Var3 as MATLAB does, maybe behind an empty cell. Bare numbers may be a first point, unless the next line
/// has decimals, or they are more than a point would have. `rest` is the text below the line.
std::optional<ColumnNumbers> column_numbers(std::string_view line, std::string_view rest);

}  // namespace segserve::codec
