// SPDX-License-Identifier: Apache-2.0
#include "core/codec/las/las_dimensions.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <utility>

#include "core/codec/common/field_roles.hpp"
#include "core/codec/common/scalar_type.hpp"
#include "core/codec/common/text_parsing.hpp"
#include "core/codec/las/las_header.hpp"

namespace segserve::codec {
namespace {

constexpr std::size_t kMostNameBytes = 32;

double value_of(const Attribute& attribute, std::size_t point) {
  return visit_type(attribute.type, [&]<typename T>(T) {
    return static_cast<double>(load<T>(attribute.values.data() + point * sizeof(T)));
  });
}

/// The integer that a field stores for a value; not finite if it cannot store it, up to a rounding of angles.
double stored_value(const LasField& field, double value) {
  constexpr double kTolerance = 1e-3;  // degrees
  const double stored = std::round(value / field.factor);
  if (!(std::abs(stored * field.factor - value) <= (field.is_angle() ? kTolerance : 0))) return std::nan("");
  const int bits = field.is_packed() ? static_cast<int>(field.bits) : static_cast<int>(8 * size_of(field.type));
  const bool is_signed = field.type == ScalarType::kInt16;
  const double low = is_signed ? -std::ldexp(1.0, bits - 1) : 0, above = std::ldexp(1.0, is_signed ? bits - 1 : bits);
  return stored >= low && stored < above ? stored : std::nan("");
}

/// The number that the specification gives to a type.
std::uint8_t type_number(ScalarType type, std::size_t count) {
  constexpr std::array<std::uint8_t, 10> kNumbers{2, 4, 6, 8, 1, 3, 5, 7, 9, 10};
  return static_cast<std::uint8_t>(kNumbers[static_cast<std::size_t>(type)] + 10 * (count - 1));
}

bool counts_returns(const LasField& field) {
  return field.name == "return_number" || field.name == "number_of_returns";
}

}  // namespace

LasDimensions::LasDimensions(const FileContent& content, const std::vector<std::uint32_t>& points,
                             const LasLayout& layout, std::vector<Warning>& warnings)
    : points_(points), begin_(layout.bytes), end_(layout.bytes) {
  if (!content.label.empty()) {
    const auto* const labels = reinterpret_cast<const std::byte*>(content.label.data());
    describe("segment", ScalarType::kUint32, 1, {labels, sizeof(std::uint32_t), sizeof(std::uint32_t), 0}, warnings);
  }
  for (const Attribute& attribute : content.attributes) {
    if (!add_standard(attribute, layout)) add_extra(attribute.name, attribute, warnings);
  }
  for (const LasField& field : layout.fields) {  // a point that nothing else is said of is the only return of its pulse
    const bool is_set = std::ranges::any_of(standards_, [&](const Standard& s) { return s.field.name == field.name; });
    if (counts_returns(field) && !is_set) standards_.push_back({nullptr, field});
  }
}

bool LasDimensions::add_standard(const Attribute& attribute, const LasLayout& layout) {
  if (attribute.count != 1) return false;
  const bool is_wide = attribute.type == ScalarType::kInt64 || attribute.type == ScalarType::kUint64;
  LasField field{attribute.name, ScalarType::kFloat64, *layout.gps_time};
  if (attribute.name == "gps_time") {
    if (is_wide) return false;
  } else {
    const auto found = std::ranges::find(layout.fields, attribute.name, &LasField::name);
    if (found == layout.fields.end()) return false;
    field = *found;
    const bool fits = std::ranges::all_of(
        points_, [&](std::uint32_t point) { return std::isfinite(stored_value(field, value_of(attribute, point))); });
    if (!fits) return false;
  }
  const bool is_taken = std::ranges::any_of(standards_, [&](const Standard& s) { return s.field.name == field.name; });
  if (!is_taken) standards_.push_back({&attribute, field});
  return !is_taken;
}

std::string LasDimensions::free_name(std::string name) const {
  const std::string base = name.substr(0, kMostNameBytes - 6);
  name.resize(std::min(name.size(), kMostNameBytes));
  for (int number = 2; std::ranges::find(names_, name) != names_.end(); ++number) {
    name = fmt::format("{}_{}", base, number);
  }
  return name;
}

void LasDimensions::add_extra(std::string name, const Attribute& attribute, std::vector<Warning>& warnings) {
  constexpr std::size_t kMostCount = 3;
  if (has_meaning(name) || name == "segment") name = "input_" + name;
  const std::size_t stride = attribute.bytes_per_point(), bytes = size_of(attribute.type);
  if (attribute.count <= kMostCount) {
    return describe(name, attribute.type, attribute.count, {attribute.values.data(), stride, stride, 0}, warnings);
  }
  for (std::size_t k = 0; k < attribute.count; ++k) {
    describe(fmt::format("{}_{}", name, k), attribute.type, 1, {attribute.values.data() + k * bytes, stride, bytes, 0},
             warnings);
  }
}

void LasDimensions::describe(std::string name, ScalarType type, std::size_t count, const Copy& copy,
                             std::vector<Warning>& warnings) {
  constexpr std::size_t kMostBytes = 65535;
  if (descriptions_.size() + kLasExtraDescriptionBytes > kMostBytes || end_ + copy.bytes > kMostBytes) {
    warnings.push_back({WarningReason::kAttributeNotKept,
                        fmt::format("the values of {} are not kept, because LAS has no room for more", quoted(name))});
    return;
  }
  name = free_name(std::move(name));
  std::string description(kLasExtraDescriptionBytes, '\0');
  description[2] = static_cast<char>(type_number(type, count));
  std::memcpy(description.data() + 4, name.data(), name.size());
  descriptions_ += description;
  names_.push_back(std::move(name));
  copies_.push_back({copy.data, copy.stride, copy.bytes, end_});
  end_ += copy.bytes;
}

void LasDimensions::set_packed(const LasField& field, unsigned value, char* record) const {
  const unsigned byte = static_cast<unsigned char>(record[field.offset]) | value << field.shift;
  record[field.offset] = static_cast<char>(byte);
}

void LasDimensions::write(char* records, std::size_t record_bytes) const {
  for (const Copy& copy : copies_) {
    char* record = records;
    for (const std::uint32_t point : points_) {
      std::memcpy(record + copy.offset, copy.data + point * copy.stride, copy.bytes);
      record += record_bytes;
    }
  }
  for (const auto& [attribute, field] : standards_) {
    char* record = records;
    for (const std::uint32_t point : points_) {
      const double value = attribute == nullptr ? 1 : value_of(*attribute, point);
      if (field.type == ScalarType::kFloat64) {
        std::memcpy(record + field.offset, &value, sizeof value);
      } else if (field.is_packed()) {
        set_packed(field, static_cast<unsigned>(value), record);
      } else {
        // The low bytes of a number are its value in any smaller type that can hold it.
        const auto stored = static_cast<std::int32_t>(stored_value(field, value));
        std::memcpy(record + field.offset, &stored, size_of(field.type));
      }
      record += record_bytes;
    }
  }
}

}  // namespace segserve::codec
