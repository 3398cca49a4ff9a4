// SPDX-License-Identifier: Apache-2.0
#include "core/codec/common/typed_rows.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "core/codec/common/text_parsing.hpp"

namespace segserve::codec {
namespace {

ScalarType kept_type(ScalarType declared, bool is_coordinate) {
  if (is_coordinate) return ScalarType::kFloat64;
  if (is_float(declared) || declared == ScalarType::kUint64) return declared;
  return ScalarType::kInt64;
}

/// Whether the type has this number.
bool holds(ScalarType type, double number) {
  return visit_type(type, [number]<typename T>(T) {
    if constexpr (std::is_floating_point_v<T>) {
      return true;
    } else {
      constexpr double kLeast = static_cast<double>(std::numeric_limits<T>::min());
      const double above = std::ldexp(1.0, std::numeric_limits<T>::digits);
      return number >= kLeast && number < above && number == std::floor(number);
    }
  });
}

}  // namespace

void TypedRows::add_field(ScalarType declared, std::size_t count, bool is_coordinate) {
  const ScalarType type = kept_type(declared, is_coordinate);
  fields_.push_back({bytes_, count, declared, type});
  bytes_ += count * size_of(type);
}

void TypedRows::allocate(std::size_t rows) {
  rows_ = rows;
  data_ = std::make_unique_for_overwrite<std::byte[]>(rows * bytes_);  // Each byte is written before it is read.
}

/// Makes doubles of the field's integers before this one. Both have 8 bytes.
void TypedRows::widen(std::size_t row, TextField& field, std::size_t index) {
  for (std::size_t i = 0; i <= row; ++i) {
    const std::size_t end = i < row ? field.count : index;
    for (std::size_t k = 0; k < end; ++k) {
      std::byte* const value = place(i, field, k);
      const double number = field.type == ScalarType::kInt64 ? static_cast<double>(load<std::int64_t>(value))
                                                             : static_cast<double>(load<std::uint64_t>(value));
      std::memcpy(value, &number, sizeof number);
    }
  }
  field.type = ScalarType::kFloat64;
}

bool TypedRows::put(std::size_t row, std::size_t index_of_field, std::size_t index, std::string_view word) {
  TextField& field = fields_[index_of_field];
  std::byte* const value = place(row, field, index);
  if (parse_scalar(word, field.type, value)) return true;
  double number = 0;
  const bool is_number =
      !is_float(field.type) && parse_scalar(word, ScalarType::kFloat64, reinterpret_cast<std::byte*>(&number));
  if (is_number) {
    widen(row, field, index);
    std::memcpy(value, &number, sizeof number);
  } else {
    std::fill_n(value, size_of(field.type), std::byte{0});
  }
  return is_number;
}

ScalarType TypedRows::fitting_type(std::size_t index_of_field, StopCheck& check) const {
  const TextField& field = fields_[index_of_field];
  bool fits = true;
  for (std::size_t k = 0; k < field.count; ++k) {
    const Column column{place(0, field, k), bytes_, field.type};
    for_each_value(column, rows_, check,
                   [&](std::size_t, auto value) { fits = fits && holds(field.declared, static_cast<double>(value)); });
  }
  return fits ? field.declared : field.type;
}

}  // namespace segserve::codec
