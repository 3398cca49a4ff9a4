// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "core/codec/common/scalar_type.hpp"
#include "segserve/codec/labeled_cloud.hpp"

// The columns of a file that is written, for formats that have named fields.
namespace segserve::codec {

/// The values of one field. Those of point i begin at data + i * stride, `count` numbers next to each other.
struct FileColumn {
  std::string name;
  ScalarType type = ScalarType::kFloat32;
  std::size_t count = 1;
  const std::byte* data = nullptr;
  std::size_t stride = 0;

  std::size_t bytes() const { return size_of(type) * count; }
};

/// How a format has colors.
enum class ColorForm : std::uint8_t {
  kPacked,    ///< one field `rgb`, 0x00RRGGBB
  kChannels,  ///< three fields of bytes: `red`, `green`, `blue`
};

/// All columns of a content: x, y, z, the color, the attributes, and `label`. An attribute whose name is not a word
/// gets
/// '_' for each character that a word cannot have; one whose name has a meaning for the readers of this project gets
/// `input_` in front of it; a name that occurs twice gets a number. The content must outlive the table.
class FileTable {
 public:
  FileTable(const FileContent& content, ColorForm form);
  FileTable(const FileTable&) = delete;
  FileTable& operator=(const FileTable&) = delete;
  FileTable(FileTable&&) = default;
  FileTable& operator=(FileTable&&) = default;
  ~FileTable() = default;

  const std::vector<FileColumn>& columns() const { return columns_; }
  std::size_t points() const { return points_; }
  /// Bytes of all columns of one point.
  std::size_t point_bytes() const;

  /// Appends the points one after the other, each with all its columns, in little-endian order.
  void append_rows(std::string& out) const;
  /// Appends the columns one after the other, each with all its points.
  void append_columns(std::string& out) const;
  /// Appends a line for each point, with the shortest numbers that read back as the same values.
  void append_text(std::string& out, char separator = ' ') const;

 private:
  void add(std::string name, ScalarType type, const void* data, std::size_t stride);
  void add_position(const FileContent& content);
  void add_color(const FileContent& content, ColorForm form);
  void add_attribute(const Attribute& attribute);

  std::size_t points_;
  std::vector<FileColumn> columns_;
  std::vector<std::uint32_t> rgb_;  // without the top byte
};

}  // namespace segserve::codec
