// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/codec/common/scalar_type.hpp"
#include "segserve/cloud.hpp"
#include "segserve/codec/labeled_cloud.hpp"
#include "segserve/stop_token.hpp"

// The fields of a PCD or PLY file: which of them matter, and how their values become a cloud with labels.
namespace segserve::codec {

/// The fields of a file that a cloud is made from, as indices.
struct FieldRoles {
  std::array<std::size_t, 3> position{};               ///< x, y, z
  std::optional<std::size_t> packed;                   ///< color as 0xAARRGGBB
  std::optional<std::array<std::size_t, 3>> channels;  ///< color as red, green and blue
  std::optional<std::size_t> label;

  bool has_color() const { return packed || channels; }
  /// All fields that have a role, each once.
  std::vector<std::size_t> fields() const;
};

/// The index at which `name` occurs, or nullopt if it does not occur. INVALID_ARGUMENT if it occurs twice.
absl::StatusOr<std::optional<std::size_t>> find_unique(const std::vector<std::string_view>& names,
                                                       std::string_view name);
/// The indices at which the three `wanted` names occur, or nullopt unless all of them do. INVALID_ARGUMENT if one of
/// them occurs twice.
absl::StatusOr<std::optional<std::array<std::size_t, 3>>> find_triple(const std::vector<std::string_view>& names,
                                                                      const std::array<std::string_view, 3>& wanted);

/// The values of one field. The value of point i begins at data + i * stride.
struct Column {
  const std::byte* data = nullptr;
  std::size_t stride = 0;
  ScalarType type = ScalarType::kFloat32;
  std::endian order = std::endian::little;
};

/// Converts the columns of the fields that have a role to the `points` points and labels of `out`. The shape becomes
/// points x 1; the caller sets another shape, and the view. The caller has checked that the columns lie within bytes at
/// hand, that positions are floats, and that a packed color has 4 bytes. INVALID_ARGUMENT for a label that is not a
/// 32-bit integer, CANCELLED, DEADLINE_EXCEEDED.
absl::Status read_columns(const FieldRoles& roles, const std::function<Column(std::size_t field)>& column,
                          std::size_t points, LabeledCloud& out, const StopToken& stop = {});

/// LabeledCloud::view_rule of a cloud whose view the caller has given.
std::string given_view_rule(const View& view);

}  // namespace segserve::codec
