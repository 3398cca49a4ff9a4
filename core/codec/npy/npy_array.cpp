// SPDX-License-Identifier: Apache-2.0
#include "core/codec/npy/npy_array.hpp"

#include <fmt/format.h>

#include <algorithm>
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

/// Whether the first axis, but for axes of length 1, is that of a few coordinates, colors and the like, and the last
/// one too long for them.
bool NpyArray::has_channels_first() const {
  constexpr std::uint64_t kFewest = 3, kMost = 8, kTooLong = 64;
  if (header_.is_structured) return false;
  const auto channels =
      std::ranges::find_if(header_.shape, [](std::uint64_t length) { return length != 1; }) - header_.shape.begin();
  const std::size_t axes = header_.shape.size() - static_cast<std::size_t>(channels);
  return (axes == 2 || axes == 3) && *(header_.shape.end() - static_cast<std::ptrdiff_t>(axes)) >= kFewest &&
         *(header_.shape.end() - static_cast<std::ptrdiff_t>(axes)) <= kMost && header_.shape.back() > kTooLong;
}

absl::Status NpyArray::put_channels_last(StopCheck& check) {
  if (!has_channels_first()) return absl::OkStatus();
  turned_shape_ = shape_text(header_);
  std::vector<std::uint64_t>& shape = header_.shape;
  while (shape.front() == 1) shape.erase(shape.begin());
  const std::size_t bytes = header_.element_bytes, channels = static_cast<std::size_t>(shape.front());
  const std::size_t points = static_cast<std::size_t>(header_.elements()) / channels;
  std::vector<std::byte> turned(channels * points * bytes);
  check.for_each(0, points, [&](std::size_t i) {
    for (std::size_t c = 0; c < channels; ++c) {
      std::memcpy(turned.data() + (i * channels + c) * bytes, data() + (c * points + i) * bytes, bytes);
    }
  });
  sorted_ = std::move(turned);
  std::ranges::rotate(shape, shape.begin() + 1);
  return check.status();
}

std::string shape_text(const NpyHeader& header) { return fmt::format("({})", fmt::join(header.shape, ", ")); }

}  // namespace segserve::codec
