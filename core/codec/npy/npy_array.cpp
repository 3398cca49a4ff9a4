// SPDX-License-Identifier: Apache-2.0
#include "core/codec/npy/npy_array.hpp"

#include <fmt/format.h>

#include <cstring>
#include <utility>

#include "core/base/status_macros.hpp"
#include "core/codec/common/limit_checks.hpp"
#include "core/codec/common/text_parsing.hpp"

namespace segserve::codec {

absl::StatusOr<NpyArray> NpyArray::open(std::span<const std::byte> file, std::string name, StopCheck& check) {
  constexpr std::size_t kMostAxes = 8;
  NpyArray array;
  ASSIGN_OR_RETURN(array.header_, parse_npy_header(as_text(file), name));
  array.name_ = std::move(name);
  const NpyHeader& header = array.header_;
  if (header.shape.size() > kMostAxes) {
    return absl::InvalidArgumentError(fmt::format("{}: it has more than {} axes", array.name_, kMostAxes));
  }
  const std::span<const std::byte> body = file.subspan(header.body_offset);
  const std::uint64_t needed = saturating_product(header.elements(), header.element_bytes);
  if (needed > body.size()) {
    return absl::InvalidArgumentError(fmt::format("{}: its shape {} needs {} bytes, but there are {}", array.name_,
                                                  shape_text(header), needed, body.size()));
  }
  array.data_ = body.data();
  array.surplus_ = body.size() - static_cast<std::size_t>(needed);
  if (header.fortran_order && header.shape.size() > 1) array.sort(check);
  RETURN_IF_ERROR(check.status());
  return array;
}

void NpyArray::sort(StopCheck& check) {
  const std::vector<std::uint64_t>& shape = header_.shape;
  const std::size_t bytes = header_.element_bytes, elements = static_cast<std::size_t>(header_.elements());
  std::vector<std::size_t> index(shape.size(), 0), stride(shape.size(), 1);
  for (std::size_t axis = 1; axis < shape.size(); ++axis) {
    stride[axis] = stride[axis - 1] * static_cast<std::size_t>(shape[axis - 1]);
  }
  sorted_.resize(elements * bytes);
  std::size_t from = 0;
  check.for_each(0, elements, [&](std::size_t i) {
    std::memcpy(sorted_.data() + i * bytes, data_ + from * bytes, bytes);
    for (std::size_t axis = shape.size(); axis-- > 0;) {
      from += stride[axis];
      if (++index[axis] < shape[axis]) break;
      from -= stride[axis] * index[axis];
      index[axis] = 0;
    }
  });
}

std::string shape_text(const NpyHeader& header) { return fmt::format("({})", fmt::join(header.shape, ", ")); }

}  // namespace segserve::codec
