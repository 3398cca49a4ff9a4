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
#include "core/codec/common/field_roles.hpp"
#include "core/codec/common/scalar_type.hpp"
#include "segserve/cloud.hpp"
#include "segserve/codec/labeled_cloud.hpp"
#include "segserve/stop_token.hpp"

// How the values of a PCD or PLY file become a cloud with labels.
namespace segserve::codec {

/// The values of one field. The value of point i begins at data + i * stride.
struct Column {
  const std::byte* data = nullptr;
  std::size_t stride = 0;
  ScalarType type = ScalarType::kFloat32;
  std::endian order = std::endian::little;
};

/// Converts the columns of the fields that have a role to the `points` points and labels of `out`, and adds warnings.
/// The shape becomes points x 1; the caller sets another shape, and the view. The caller has checked that the columns
/// lie within bytes at hand. The low 32 bits of an integer, or all of a float, are a packed color. CANCELLED,
/// DEADLINE_EXCEEDED.
absl::Status read_columns(const FieldRoles& roles, const std::function<Column(std::size_t field)>& column,
                          std::size_t points, LabeledCloud& out, const StopToken& stop = {});

/// LabeledCloud::view_rule of a cloud whose view the caller has given.
std::string given_view_rule(const View& view);

}  // namespace segserve::codec
