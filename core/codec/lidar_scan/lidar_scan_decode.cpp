// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <utility>

#include "core/base/status_macros.hpp"
#include "core/codec/common/limit_checks.hpp"
#include "core/codec/common/point_columns.hpp"
#include "core/codec/common/scalar_type.hpp"
#include "core/codec/common/text_parsing.hpp"
#include "core/codec/lidar_scan/lidar_scan.hpp"

namespace segserve::codec {
namespace {

constexpr std::string_view kPrefix = "LiDAR scan: ";
constexpr std::size_t kKitti = 4, kNuScenes = 5;  // floats of a point
constexpr std::array<std::string_view, kNuScenes> kNames{"x", "y", "z", "intensity", "ring"};

/// Zeros, and numbers that stand for meters. The bytes of text, integers and doubles look otherwise as floats: far too
/// small or too large.
bool is_coordinate(float value) {
  constexpr float kSmallest = 1e-6F, kLargest = 1000;
  return value == 0 || (std::abs(value) >= kSmallest && std::abs(value) <= kLargest);
}

bool is_point(std::span<const float> values) {
  constexpr float kMostRings = 256;
  if (!std::all_of(values.begin(), values.begin() + 3, is_coordinate)) return false;
  const float intensity = values[3];
  if (!(intensity >= 0 && (intensity <= 1 || (intensity <= 255 && intensity == std::floor(intensity))))) return false;
  return values.size() < kNuScenes || (values[4] >= 0 && values[4] < kMostRings && values[4] == std::floor(values[4]));
}

/// Whether the first points, of so many floats each, are those of a LiDAR, but for one in a hundred, whatever it is.
bool has_points(std::string_view begin, std::size_t floats) {
  constexpr std::size_t kFewest = 16, kEnough = 4096;
  const std::size_t points = std::min(begin.size() / (floats * sizeof(float)), kEnough);
  std::size_t odd = 0, apart = 0;  // no points of a LiDAR; points apart from the origin
  std::array<float, kNuScenes> values{};
  for (std::size_t i = 0; i < points; ++i) {
    for (std::size_t k = 0; k < floats; ++k) {
      const std::size_t offset = (i * floats + k) * sizeof(float);
      values[k] = load<float>(reinterpret_cast<const std::byte*>(begin.data() + offset), std::endian::little);
    }
    if (!is_point(std::span(values).first(floats))) {
      ++odd;
    } else if (values[0] != 0 || values[1] != 0 || values[2] != 0) {
      ++apart;
    }
  }
  return points >= kFewest && 100 * odd <= points && 2 * apart > points;
}

/// The floats of a point; 0 if the file is no such scan. Four come first, because the positions of nuScenes, taken four
/// at a time, are soon negative where an intensity should be.
std::size_t floats_of(std::string_view begin, std::uint64_t file_bytes) {
  for (const std::size_t floats : {kKitti, kNuScenes}) {
    if (file_bytes % (floats * sizeof(float)) == 0 && has_points(begin, floats)) return floats;
  }
  return 0;
}

}  // namespace

bool is_lidar_scan(std::string_view begin, std::uint64_t file_bytes) { return floats_of(begin, file_bytes) != 0; }

absl::StatusOr<LabeledCloud> decode_lidar_scan(std::span<const std::byte> bytes, const DecodeLimits& limits,
                                               const ReadOptions& options, const StopToken& stop) {
  RETURN_IF_ERROR(check_bytes(kPrefix, bytes.size(), limits));
  const std::size_t floats = floats_of(as_text(bytes), bytes.size());
  if (floats == 0) return absl::InvalidArgumentError("the file is no LiDAR scan of KITTI or nuScenes");
  const std::size_t stride = floats * sizeof(float), points = bytes.size() / stride;
  RETURN_IF_ERROR(check_points(kPrefix, points, limits));
  RETURN_IF_ERROR(check_decoded_points(kPrefix, points, stride, limits));
  PointTable table;
  for (std::size_t k = 0; k < floats; ++k) table.fields.push_back({kNames[k], ScalarType::kFloat32});
  table.roles.position = {0, 1, 2};
  table.width = static_cast<std::uint32_t>(points);
  table.height = 1;
  table.column = [bytes, stride](std::size_t field) {
    return Column{bytes.data() + field * sizeof(float), stride, ScalarType::kFloat32, std::endian::little};
  };
  LabeledCloud out;
  RETURN_IF_ERROR(read_points(table, {.stated = View::world(0, 0, 0)}, options, stop, out));
  return out;
}

}  // namespace segserve::codec
