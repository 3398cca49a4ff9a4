// SPDX-License-Identifier: Apache-2.0
#include "core/codec/common/point_positions.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "core/base/status_macros.hpp"
#include "core/codec/common/no_data.hpp"
#include "core/codec/common/spacing_search.hpp"
#include "core/codec/common/unit_guess.hpp"

namespace segserve::codec {
namespace {

/// A cloud is moved if its median is farther from 0 than this along an axis, in meters. Floats are exact to 0.03 mm
/// there.
constexpr double kFar = 512;
/// Nothing on earth is farther away, in meters. Beyond it, numbers are no coordinates.
constexpr double kFarthest = 1e8;

using Planes = std::array<std::vector<float>*, 3>;

/// Sets the plane to scale * (value - offset).
void read_axis(const Column& column, double scale, double offset, StopCheck& check, std::vector<float>& plane) {
  float* const out = plane.data();
  if (scale == 1 && offset == 0) {
    for_each_value(column, plane.size(), check,
                   [out](std::size_t i, auto value) { out[i] = static_cast<float>(value); });
  } else {
    for_each_value(column, plane.size(), check, [out, scale, offset](std::size_t i, auto value) {
      out[i] = static_cast<float>(scale * (static_cast<double>(value) - offset));
    });
  }
}

/// Warns of points with coordinates that are finite in the file, and beyond what a float holds.
void warn_of_overflow(const std::array<Column, 3>& columns, const Planes& planes, const NoDataPoints& no_data,
                      StopCheck& check, std::vector<Warning>& warnings) {
  std::vector<bool> is_beyond;
  std::size_t count = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (columns[axis].type != ScalarType::kFloat64) continue;
    const std::vector<float>& plane = *planes[axis];
    for_each_value(columns[axis], plane.size(), check, [&](std::size_t i, auto value) {
      if (!std::isinf(plane[i]) || !std::isfinite(static_cast<double>(value)) || no_data.has(i)) return;
      is_beyond.resize(plane.size());
      count += is_beyond[i] ? 0 : 1;
      is_beyond[i] = true;
    });
  }
  if (count == 0) return;
  warnings.push_back(
      {WarningReason::kPointsNotUsed, fmt::format("{} point{} beyond 3e38 m, which no float holds, {} not used", count,
                                                  count == 1 ? "" : "s", count == 1 ? "is" : "are")});
}

/// Whether any coordinate of the plane is finite and far from 0.
bool reaches_far(const std::vector<float>& plane, StopCheck& check) {
  constexpr float kLargest = std::numeric_limits<float>::max();
  bool far = false;
  check.for_each(0, plane.size(), [&](std::size_t i) {
    const float magnitude = std::abs(plane[i]);
    far |= magnitude > static_cast<float>(kFar) && magnitude <= kLargest;
  });
  return far;
}

/// The median of the measured values that are finite; 0 if there are none. It does not depend on the order of the
/// points.
double median(const Column& column, std::size_t points, const NoDataPoints& no_data, StopCheck& check) {
  std::vector<double> values;
  values.reserve(points);
  for_each_value(column, points, check, [&](std::size_t i, auto value) {
    if (std::isfinite(static_cast<double>(value)) && !no_data.has(i)) values.push_back(static_cast<double>(value));
  });
  if (values.empty() || check.after(8 * values.size())) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// The shift of the axes, in the file's unit; none unless the cloud is far away along one of them.
Eigen::Vector3d offset_of(const std::array<Column, 3>& columns, double scale, const Planes& planes,
                          const NoDataPoints& no_data, StopCheck& check) {
  bool is_candidate = false;
  for (const std::vector<float>* plane : planes) is_candidate = is_candidate || reaches_far(*plane, check);
  if (!is_candidate) return Eigen::Vector3d::Zero();
  const double step = std::round(1 / scale);
  Eigen::Vector3d offset;
  bool is_far = false;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double middle = median(columns[axis], planes[axis]->size(), no_data, check);
    if (std::abs(middle) * scale > kFarthest) return Eigen::Vector3d::Zero();
    is_far = is_far || std::abs(middle) * scale > kFar;
    offset[static_cast<Eigen::Index>(axis)] = std::round(middle / step) * step;
  }
  return is_far ? offset : Eigen::Vector3d::Zero();
}

/// Warns of a file whose floats of 32 bits are too coarse for points that are so far away.
void warn_of_rounding(const std::array<Column, 3>& columns, double scale, StopCheck& check, LabeledCloud& out) {
  double step = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (columns[axis].type != ScalarType::kFloat32) continue;
    const auto typical = static_cast<float>(std::abs(out.placement.offset[static_cast<Eigen::Index>(axis)]));
    const auto next = std::bit_cast<float>(std::bit_cast<std::uint32_t>(typical) + 1);
    step = std::max(step, scale * (static_cast<double>(next) - typical));
  }
  const auto spacing = step > 0 ? point_spacing(out.cloud, check) : std::nullopt;
  if (!spacing || step <= *spacing / 4) return;
  out.warnings.push_back({WarningReason::kCoordinatesRounded,
                          fmt::format("the coordinates are rounded to {:.2g} m, because the file has them as floats of "
                                      "4 bytes so far from 0; save them as doubles, or near 0",
                                      step)});
}

void keep_position(const std::array<Column, 3>& columns, bool are_floats, StopCheck& check, LabeledCloud& out) {
  if (are_floats && out.placement.is_identity()) return;  // The cloud has them.
  for (std::size_t axis = 0; axis < 3; ++axis) {
    std::vector<double>& position = out.file_position[axis];
    position.resize(out.cloud.size());
    for_each_value(columns[axis], position.size(), check,
                   [&position](std::size_t i, auto value) { position[i] = static_cast<double>(value); });
  }
}

/// Whether points at (0, 0, 0) can be no part of a surface, because there are many of them, and no others near them.
bool are_fill_values(const Cloud& cloud, StopCheck& check) {
  constexpr std::size_t kFewest = 10;
  constexpr double kAway = 4;  // distances of neighboring points
  std::size_t zeros = 0;
  double nearest = std::numeric_limits<double>::infinity();
  check.for_each(0, cloud.size(), [&](std::size_t i) {
    if (!is_finite(cloud.x[i], cloud.y[i], cloud.z[i])) return;
    const Eigen::Vector3d p(cloud.x[i], cloud.y[i], cloud.z[i]);
    if (p.isZero(0)) {
      ++zeros;
    } else {
      nearest = std::min(nearest, p.squaredNorm());
    }
  });
  if (zeros < kFewest || std::isinf(nearest)) return false;
  const std::optional<double> spacing = point_spacing(cloud, check);
  return spacing && nearest > kAway * kAway * *spacing * *spacing;
}

/// Makes points at the origin, which are no measurement for this reason, points that are not finite.
void drop_zeros(std::string_view reason, StopCheck& check, LabeledCloud& out) {
  Cloud& cloud = out.cloud;
  std::size_t zeros = 0;
  check.for_each(0, cloud.size(), [&](std::size_t i) {
    if (cloud.x[i] != 0 || cloud.y[i] != 0 || cloud.z[i] != 0) return;
    ++zeros;
    cloud.x[i] = cloud.y[i] = cloud.z[i] = std::numeric_limits<float>::quiet_NaN();
  });
  if (zeros == 0) return;
  out.warnings.push_back(
      {WarningReason::kPointsNotUsed, fmt::format("{} point{} at (0, 0, 0), {}, {}", zeros, zeros == 1 ? "" : "s",
                                                  reason, zeros == 1 ? "is no measurement" : "are no measurements")});
}

void reverse(std::vector<float>& plane, StopCheck& check) {
  check.for_each(0, plane.size(), [&](std::size_t i) { plane[i] = -plane[i]; });
}

}  // namespace

absl::Status read_positions(const std::array<Column, 3>& columns, bool are_floats, ViewEvidence evidence,
                            const ReadOptions& options, StopCheck& check, LabeledCloud& out) {
  Cloud& cloud = out.cloud;
  const Planes planes{&cloud.x, &cloud.y, &cloud.z};
  const LengthUnit unit = options.unit.value_or(LengthUnit::kMeter);
  const double scale =
      unit == LengthUnit::kAuto ? guess_unit(columns, cloud.size(), check, out.warnings) : meters_per_unit(unit);
  for (std::size_t axis = 0; axis < 3; ++axis) read_axis(columns[axis], scale, 0, check, *planes[axis]);
  const NoDataPoints no_data = NoDataPoints::find(columns, cloud.size(), check);
  no_data.drop(cloud, check);
  no_data.warn(out.warnings);
  evidence.given = options.view;
  if (evidence.position) *evidence.position *= scale;
  if (evidence.stated && evidence.stated->sensor) {
    evidence.stated->sensor = (scale * evidence.stated->sensor->cast<double>()).cast<float>();
  }
  ASSIGN_OR_RETURN(ViewChoice choice, choose_view(cloud, evidence, check));

  Placement& placement = out.placement;
  placement.scale.setConstant(scale);
  if (choice.y_and_z_are_reversed) {
    placement.scale = {scale, -scale, -scale};
    reverse(cloud.y, check);
    reverse(cloud.z, check);
  }
  if (choice.kind == ViewKind::kWorld) {
    placement.offset = offset_of(columns, scale, planes, no_data, check);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double offset = placement.offset[static_cast<Eigen::Index>(axis)];
      if (offset != 0) read_axis(columns[axis], scale, offset, check, *planes[axis]);
    }
    no_data.drop(cloud, check);
    if (!placement.offset.isZero(0)) warn_of_rounding(columns, scale, check, out);
  }
  warn_of_overflow(columns, planes, no_data, check, out.warnings);
  const bool is_at_origin = choice.sensor && choice.sensor->isZero(0);
  if (is_at_origin) {
    drop_zeros("where the sensor is", check, out);
  } else if (placement.offset.isZero(0) && are_fill_values(cloud, check)) {
    drop_zeros("far from all others", check, out);
  }
  if (options.keep_everything) keep_position(columns, are_floats, check, out);
  cloud.view = {choice.kind, std::nullopt};
  if (choice.sensor) {
    const Eigen::Vector3d sensor = *choice.sensor - scale * placement.offset;
    cloud.view.sensor = sensor.cast<float>();
  }
  cloud.view.cameras = std::move(choice.cameras);
  for (CameraPoints& camera : cloud.view.cameras) {
    const Eigen::Vector3d sensor = camera.sensor.cast<double>() - scale * placement.offset;
    camera.sensor = sensor.cast<float>();
  }
  out.view_rule = std::move(choice.rule);
  return check.status();
}

}  // namespace segserve::codec
