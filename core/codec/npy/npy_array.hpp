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

  const std::string& name() const { return name_; }
  const NpyHeader& header() const { return header_; }
  const std::byte* data() const { return sorted_.empty() ? data_ : sorted_.data(); }
  /// Bytes behind the last element.
  std::size_t surplus() const { return surplus_; }

 private:
  void sort(StopCheck& check);

  std::string name_;
  NpyHeader header_;
  const std::byte* data_ = nullptr;
  std::vector<std::byte> sorted_;
  std::size_t surplus_ = 0;
};

/// "(480, 640, 3)".
std::string shape_text(const NpyHeader& header);

}  // namespace segserve::codec
