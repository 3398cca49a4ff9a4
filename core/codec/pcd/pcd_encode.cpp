// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <lzf.h>

#include <cstring>
#include <iterator>
#include <limits>

#include "core/codec/common/file_columns.hpp"
#include "core/codec/common/file_statements.hpp"
#include "core/codec/pcd/pcd_viewpoint.hpp"
#include "segserve/codec/pcd.hpp"

namespace segserve::codec {
namespace {

std::string_view name_of(PcdEncoding encoding) {
  switch (encoding) {
    case PcdEncoding::kAscii:
      return "ascii";
    case PcdEncoding::kBinary:
      return "binary";
    case PcdEncoding::kBinaryCompressed:
      break;
  }
  return "binary_compressed";
}

/// The entry TYPE of a column. PCL has the bits of a color in a float; as text, some colors would then be NaN.
char type_of(const FileColumn& column, PcdEncoding encoding) {
  if (column.name == "rgb" && encoding != PcdEncoding::kAscii) return 'F';
  if (is_float(column.type)) return 'F';
  return column.type < ScalarType::kUint8 ? 'I' : 'U';
}

std::string encode_header(const FileContent& content, const FileTable& table, PcdEncoding encoding) {
  std::string fields, sizes, types, counts;
  for (const FileColumn& column : table.columns()) {
    fields += ' ' + column.name;
    fmt::format_to(std::back_inserter(sizes), " {}", size_of(column.type));
    fmt::format_to(std::back_inserter(types), " {}", type_of(column, encoding));
    fmt::format_to(std::back_inserter(counts), " {}", column.count);
  }
  const CloudView& cloud = content.cloud;
  std::string viewpoint;
  if (keeps_viewpoint(content)) {
    const auto& [translation, q] = *content.viewpoint;
    viewpoint = fmt::format("{} {} {} {} {}", fmt::join(translation, " "), q.w(), q.x(), q.y(), q.z());
  } else {
    const Eigen::Vector3f sensor = cloud.view.sensor.value_or(Eigen::Vector3f::Zero());
    viewpoint = fmt::format("{} 1 0 0 0", fmt::join(sensor, " "));
  }
  return fmt::format(
      "# .PCD v0.7 - Point Cloud Data file format\n# {}\nVERSION 0.7\nFIELDS{}\nSIZE{}\nTYPE{}\nCOUNT{}\n"
      "WIDTH {}\nHEIGHT {}\nVIEWPOINT {}\nPOINTS {}\nDATA {}\n",
      fmt::join(statements_of(content), "\n# "), fields, sizes, types, counts, cloud.width, cloud.height, viewpoint,
      cloud.size(), name_of(encoding));
}

/// The most bytes that LZF writes: a control byte before each 32 bytes, and the space that it wants to have ahead.
std::size_t compressed_bound(std::size_t bytes) { return bytes + bytes / 32 + 16; }

/// Appends the body of binary_compressed: the compressed and the decompressed size, and one LZF block.
void append_compressed(const std::string& planes, std::string& out) {
  constexpr std::size_t kSizes = 2 * sizeof(std::uint32_t);
  const std::size_t begin = out.size();
  out.resize(begin + kSizes + compressed_bound(planes.size()));
  const auto size = static_cast<std::uint32_t>(planes.size());
  std::uint32_t compressed = 0;
  if (size > 0) {  // LZF takes no empty block.
    compressed = lzf_compress(planes.data(), size, out.data() + begin + kSizes,
                              static_cast<unsigned>(out.size() - begin - kSizes));
  }
  std::memcpy(out.data() + begin, &compressed, sizeof compressed);
  std::memcpy(out.data() + begin + sizeof compressed, &size, sizeof size);
  out.resize(begin + kSizes + compressed);
}

}  // namespace

std::string encode_pcd(const FileContent& content, PcdEncoding encoding) {
  const FileTable table(content, ColorForm::kPacked);
  const std::size_t body_bytes = table.points() * table.point_bytes();
  if (encoding == PcdEncoding::kBinaryCompressed &&
      compressed_bound(body_bytes) > std::numeric_limits<std::uint32_t>::max()) {
    encoding = PcdEncoding::kBinary;
  }
  std::string out = encode_header(content, table, encoding);
  switch (encoding) {
    case PcdEncoding::kAscii:
      table.append_text(out);
      return out;
    case PcdEncoding::kBinary:
      table.append_rows(out);
      return out;
    case PcdEncoding::kBinaryCompressed:
      break;
  }
  std::string planes;
  table.append_columns(planes);
  append_compressed(planes, out);
  return out;
}

std::string encode_pcd(const CloudView& cloud, std::span<const std::uint32_t> label, PcdEncoding encoding) {
  return encode_pcd(FileContent{.cloud = cloud, .label = label}, encoding);
}

}  // namespace segserve::codec
