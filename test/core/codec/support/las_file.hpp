// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>

namespace segserve::codec {

/// Writes a number over bytes of a string.
template <typename T>
void put(std::string& bytes, std::size_t offset, T value) {
  std::memcpy(bytes.data() + offset, &value, sizeof value);
}

/// A variable length record of a LAS file.
inline std::string las_record(std::string_view user, std::uint16_t id, std::string_view payload) {
  std::string record(54, '\0');
  std::memcpy(record.data() + 2, user.data(), user.size());
  put(record, 18, id);
  put(record, 20, static_cast<std::uint16_t>(payload.size()));
  return record.append(payload);
}

/// An extended variable length record.
inline std::string las_extended_record(std::string_view user, std::uint16_t id, std::string_view payload) {
  std::string record(60, '\0');
  std::memcpy(record.data() + 2, user.data(), user.size());
  put(record, 18, id);
  put(record, 20, std::uint64_t{payload.size()});
  return record.append(payload);
}

/// The description of an extra dimension, of a data type of the specification.
inline std::string las_extra(std::string_view name, std::uint8_t type, std::uint8_t options = 0) {
  std::string description(192, '\0');
  put(description, 2, type);
  put(description, 3, options);
  std::memcpy(description.data() + 4, name.data(), name.size());
  return description;
}

/// A LAS file whose points are `record_bytes` each, all 0 but for X = 100 i, Y = 200 i, Z = 300 i; scale 0.01,
/// offset 1, 2, 3.
struct LasFile {
  unsigned minor = 2, format = 0;
  std::size_t record_bytes = 20;
  std::string records;
  std::uint32_t record_count = 0;
  std::uint32_t points = 0;
  std::string body = {};

  void fill() {
    body.assign(points * record_bytes, '\0');
    for (std::uint32_t i = 0; i < points; ++i) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        put(body, i * record_bytes + 4 * axis, static_cast<std::int32_t>(100 * (axis + 1) * i));
      }
    }
  }
  std::string bytes() const {
    const std::size_t header_bytes = minor >= 4 ? 375 : minor == 3 ? 235 : 227;
    std::string header(header_bytes, '\0');
    std::memcpy(header.data(), "LASF", 4);
    put<std::uint8_t>(header, 24, 1);
    put(header, 25, static_cast<std::uint8_t>(minor));
    put(header, 94, static_cast<std::uint16_t>(header_bytes));
    put(header, 96, static_cast<std::uint32_t>(header_bytes + records.size()));
    put(header, 100, record_count);
    put(header, 104, static_cast<std::uint8_t>(format));
    put(header, 105, static_cast<std::uint16_t>(record_bytes));
    if (minor < 4) put(header, 107, points);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      put(header, 131 + 8 * axis, 0.01);
      put(header, 155 + 8 * axis, static_cast<double>(axis + 1));
    }
    if (minor >= 4) put(header, 247, std::uint64_t{points});
    return header + records + body;
  }
};

/// A file with points of the format.
inline LasFile las_file(unsigned minor, unsigned format, std::size_t record_bytes, std::uint32_t points) {
  LasFile file{.minor = minor, .format = format, .record_bytes = record_bytes, .records = {}, .points = points};
  file.fill();
  return file;
}

}  // namespace segserve::codec
