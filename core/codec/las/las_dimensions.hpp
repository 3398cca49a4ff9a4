// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "core/codec/las/las_fields.hpp"
#include "segserve/codec/attribute.hpp"
#include "segserve/codec/labeled_cloud.hpp"
#include "segserve/codec/warning.hpp"

namespace segserve::codec {

/// Where the labels and attributes of a cloud go in the records of a LAS file.
class LasDimensions {
 public:
  /// Everything must outlive the object. `points` are those that are written. Warns of what does not fit.
  LasDimensions(const FileContent& content, const std::vector<std::uint32_t>& points, const LasLayout& layout,
                std::vector<Warning>& warnings);

  /// Bytes of a record behind those of its format.
  std::size_t extra_bytes() const { return end_ - begin_; }
  /// The payload of the record that describes the extra bytes.
  const std::string& descriptions() const { return descriptions_; }
  /// Writes all values into records, which are 0 there.
  void write(char* records, std::size_t record_bytes) const;

 private:
  /// Numbers that are written as they are: `bytes` at `data + point * stride`.
  struct Copy {
    const std::byte* data;
    std::size_t stride, bytes, offset;
  };
  struct Standard {
    const Attribute* attribute;
    LasField field;
  };

  bool add_standard(const Attribute& attribute, const LasLayout& layout);
  void add_extra(std::string name, const Attribute& attribute, std::vector<Warning>& warnings);
  void describe(std::string name, ScalarType type, std::size_t count, const Copy& copy, std::vector<Warning>& warnings);
  std::string free_name(std::string name) const;
  void set_packed(const LasField& field, unsigned value, char* record) const;

  const std::vector<std::uint32_t>& points_;
  std::vector<Copy> copies_;
  std::vector<Standard> standards_;
  std::vector<std::string> names_;
  std::string descriptions_;
  std::size_t begin_, end_;
};

}  // namespace segserve::codec
