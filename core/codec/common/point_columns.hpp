// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <functional>
#include <optional>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/codec/common/scalar_type.hpp"
#include "segserve/codec/labeled_cloud.hpp"
#include "segserve/stop_token.hpp"

namespace segserve::codec {

/// Which of a file's fields (by index) mean something to us.
struct Roles {
  std::array<std::size_t, 3> position{};               ///< x y z
  std::optional<std::size_t> packed;                   ///< color as 0xAARRGGBB
  std::optional<std::array<std::size_t, 3>> channels;  ///< color as red, green and blue
  std::optional<std::size_t> label;

  /// All of them, each once.
  std::vector<std::size_t> fields() const;
};

/// The only index at which `name` occurs, none if it is absent; INVALID_ARGUMENT if it occurs twice.
absl::StatusOr<std::optional<std::size_t>> find_unique(const std::vector<std::string_view>& names,
                                                       std::string_view name);
/// All three or none; finding some of them is as good as none.
absl::StatusOr<std::optional<std::array<std::size_t, 3>>> find_three(const std::vector<std::string_view>& names,
                                                                     const std::array<std::string_view, 3>& wanted);

/// The values of one field: that of point i begins at data + i * stride.
struct Column {
  const std::byte* data = nullptr;
  std::size_t stride = 0;
  ScalarType type = ScalarType::kFloat32;
  std::endian order = std::endian::little;
};

/// Converts the columns to a cloud of `points` x 1 (the caller sets its shape and view) and labels.
/// The caller has checked that the columns lie within bytes at hand, and their types: a float for
/// positions, 4 bytes for packed color. INVALID_ARGUMENT for a label that is not a 32-bit integer.
absl::Status read_columns(const Roles& roles, const std::function<Column(std::size_t field)>& column,
                          std::size_t points, LabelledCloud& out, const StopToken& stop = {});

}  // namespace segserve::codec
