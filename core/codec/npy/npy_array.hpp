// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "core/base/stop_check.hpp"
#include "core/codec/npy/npy_header.hpp"

namespace segserve::codec {

/// An array whose elements lie one after the other, the last axis first.
class NpyArray {
 public:
  /// Compares what the header claims with the bytes at hand, and sorts the elements of an array in Fortran's order into
  /// memory of its own. Else the array lies in `file`, which must outlive it. `name` is for messages.
  static absl::StatusOr<NpyArray> open(std::span<const std::byte> file, std::string name, StopCheck& check);

  /// Turns an array that has the coordinates in its first axis, such as (3, N) or (1, 6, N), as programs for deep
  /// learning have it, to have them in its last.
  absl::Status put_channels_last(StopCheck& check);

  const std::string& name() const { return name_; }
  const NpyHeader& header() const { return header_; }
  const std::byte* data() const { return sorted_.empty() ? data_ : sorted_.data(); }
  /// The shape in the file if the array was turned; else empty.
  const std::string& turned_shape() const { return turned_shape_; }
  /// Bytes behind the last element.
  std::size_t surplus() const { return surplus_; }

 private:
  void sort(StopCheck& check);
  bool has_channels_first() const;

  std::string name_;
  NpyHeader header_;
  const std::byte* data_ = nullptr;
  std::vector<std::byte> sorted_;
  std::string turned_shape_;
  std::size_t surplus_ = 0;
};

/// "(480, 640, 3)".
std::string shape_text(const NpyHeader& header);

}  // namespace segserve::codec
