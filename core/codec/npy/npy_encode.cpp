// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <array>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#include "core/codec/common/file_columns.hpp"
#include "core/codec/common/file_statements.hpp"
#include "core/codec/npy/npy.hpp"

namespace segserve::codec {
namespace {

std::string_view type_name(ScalarType type) {
  constexpr std::array<std::string_view, 10> kNames{"|i1", "<i2", "<i4", "<i8", "|u1",
                                                    "<u2", "<u4", "<u8", "<f4", "<f8"};
  return kNames[static_cast<std::size_t>(type)];
}

/// The names and types of the fields, as NumPy writes them. The titles of the first ones are the statements.
std::string description(const FileTable& table, const std::vector<std::string>& statements) {
  std::string out;
  for (std::size_t i = 0; i < table.columns().size(); ++i) {
    const FileColumn& column = table.columns()[i];
    const std::string name = i < statements.size() ? fmt::format("('{}', '{}')", statements[i], column.name)
                                                   : fmt::format("'{}'", column.name);
    const std::string shape = column.count == 1 ? "" : fmt::format(", ({},)", column.count);
    out += fmt::format("{}({}, '{}'{})", i == 0 ? "" : ", ", name, type_name(column.type), shape);
  }
  return out;
}

}  // namespace

std::string encode_npy(const FileContent& content) {
  constexpr std::size_t kAlignment = 64, kFixed = 12;
  const FileTable table(content, ColorForm::kChannels);
  const CloudView& cloud = content.cloud;
  const std::string shape =
      cloud.height == 1 ? fmt::format("({},)", cloud.width) : fmt::format("({}, {})", cloud.height, cloud.width);
  std::string header = fmt::format("{{'descr': [{}], 'fortran_order': False, 'shape': {}, }}",
                                   description(table, statements_of(content)), shape);
  header.append(kAlignment - 1 - (kFixed + header.size()) % kAlignment, ' ');
  header += '\n';
  std::string out("\x93NUMPY\2\0", 8);
  const auto length = static_cast<std::uint32_t>(header.size());
  out.append(reinterpret_cast<const char*>(&length), sizeof length);
  out += header;
  table.append_rows(out);
  return out;
}

}  // namespace segserve::codec
