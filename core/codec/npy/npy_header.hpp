// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "segserve/codec/attribute.hpp"

// The header of NumPy's array files ("NEP 1: A simple file format for NumPy arrays").
namespace segserve::codec {

/// The kinds of numbers that arrays have. Those that are no ScalarType have no meaning here.
enum class NpyKind : std::uint8_t {
  kNumber,
  kHalf,   ///< floats of 16 bits
  kOther,  ///< text, dates, complex numbers and so on
};

/// One field of an array's elements. An array without fields has one, without a name.
struct NpyField {
  std::string name;
  std::string title;
  NpyKind kind = NpyKind::kNumber;
  ScalarType type = ScalarType::kFloat32;  ///< of numbers
  std::endian order = std::endian::little;
  std::size_t count = 1;   ///< numbers in each element
  std::size_t offset = 0;  ///< in the element
  std::size_t bytes = 0;   ///< of one number
};

struct NpyHeader {
  std::vector<NpyField> fields;
  bool is_structured = false;
  bool fortran_order = false;
  std::vector<std::uint64_t> shape;
  std::size_t element_bytes = 0;
  std::size_t body_offset = 0;

  /// The number of elements; the largest 64-bit number if it is more.
  std::uint64_t elements() const;
};

bool is_npy(std::string_view file);

/// Parses the header. INVALID_ARGUMENT names what is wrong, or that the elements are Python objects; begins with
/// `name`.
absl::StatusOr<NpyHeader> parse_npy_header(std::string_view file, std::string_view name);

}  // namespace segserve::codec
