// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <bit>
#include <cstddef>

#include "core/base/stop_check.hpp"
#include "core/codec/common/scalar_type.hpp"

namespace segserve::codec {

/// The values of one field. The value of point i begins at data + i * stride.
struct Column {
  const std::byte* data = nullptr;
  std::size_t stride = 0;
  ScalarType type = ScalarType::kFloat32;
  std::endian order = std::endian::little;
};

/// Calls function(i, value) with the value of each point, in the column's type.
template <typename Function>
void for_each_value(const Column& column, std::size_t points, StopCheck& check, Function function) {
  visit_type(column.type, [&]<typename T>(T) {
    const std::byte* const data = column.data;
    const std::size_t stride = column.stride;
    if (column.order == std::endian::native) {
      check.for_each(0, points, [=](std::size_t i) { function(i, load<T>(data + i * stride)); });
    } else {
      const std::endian order = column.order;
      check.for_each(0, points, [=](std::size_t i) { function(i, load<T>(data + i * stride, order)); });
    }
  });
}

}  // namespace segserve::codec
