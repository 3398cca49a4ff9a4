// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/base/stop_check.hpp"
#include "core/codec/common/file_statements.hpp"
#include "core/codec/common/point_columns.hpp"
#include "core/codec/npy/npy_array.hpp"
#include "segserve/codec/decode_limits.hpp"
#include "segserve/codec/warning.hpp"

namespace segserve::codec {

/// The names, in lower case, of arrays that have positions, three numbers for each point.
inline constexpr std::array<std::string_view, 16> kPositionArrays{
    "points", "xyz", "pos", "position", "positions",   "coord",      "coords", "vertices",
    "verts",  "pts", "pc",  "pcd",      "point_cloud", "pointcloud", "cloud",  "arr_0"};

/// Collects the columns of a cloud from arrays, which must outlive it.
class NpyTable {
 public:
  NpyTable(const DecodeLimits& limits, StopCheck& check, std::vector<Warning>& warnings)
      : limits_(limits), check_(check), warnings_(warnings) {}
  NpyTable(const NpyTable&) = delete;
  NpyTable& operator=(const NpyTable&) = delete;
  ~NpyTable() = default;

  /// Takes the shape of the points: all axes of the array but the last `column_axes`.
  absl::Status set_shape(const NpyArray& array, std::size_t column_axes);
  /// Whether an array has a value, or values, for each point.
  bool fits(const NpyArray& array) const;
  std::size_t points() const { return std::size_t{width_} * height_; }

  /// Adds the fields of a structured array.
  void add_fields(const NpyArray& array);
  /// Adds the columns of an array of shape (.., C), and gives them names by their values.
  absl::Status add_unnamed(const NpyArray& array);
  /// Adds an array of shape (..) or (.., C) under a name.
  void add_named(const NpyArray& array, const std::string& name);

  /// The table, with the roles that the names tell. It refers to this object.
  absl::StatusOr<PointTable> finish();

 private:
  void add_column(std::string name, const NpyField& field, const std::byte* data, std::size_t stride,
                  std::size_t count);

  /// Adds an array of shape (.., 4) whose fourth numbers are colors by their bits; else returns false.
  bool add_points_with_color(const NpyArray& array);

  /// The names of the columns of an array of this name, in any case, with so many numbers for each point; null if it
  /// is one value, or if there are columns of these names.
  const std::array<const char*, 3>* parts_of(std::string_view name, std::size_t count) const;

  const DecodeLimits& limits_;
  StopCheck& check_;
  std::vector<Warning>& warnings_;
  std::uint32_t width_ = 0, height_ = 1;
  std::deque<std::string> names_;
  std::vector<Field> fields_;
  std::vector<Column> columns_;
  std::deque<std::vector<float>> halves_;
  FileStatements stated_;
};

}  // namespace segserve::codec
