// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/codec/common/file_columns.hpp"
#include "core/codec/common/file_statements.hpp"
#include "core/codec/text/text_table.hpp"

namespace segserve::codec {

std::string encode_text_table(const FileContent& content, Separator separator) {
  const bool is_csv = separator == Separator::kComma;
  const FileTable table(content, ColorForm::kChannels);
  std::string names;
  for (const FileColumn& column : table.columns()) {
    for (std::size_t k = 0; k < column.count; ++k) {
      if (!names.empty()) names += is_csv ? ',' : ' ';
      names += column.count == 1 ? column.name : fmt::format("{}_{}", column.name, k);
    }
  }
  std::string out = fmt::format("# {}\n{}{}\n", fmt::join(statements_of(content), "\n# "), is_csv ? "" : "//", names);
  table.append_text(out, is_csv ? ',' : ' ');
  return out;
}

}  // namespace segserve::codec
