// SPDX-License-Identifier: Apache-2.0
#include "core/codec/view/sensor_geometry.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include "core/codec/view/view_points.hpp"

namespace segserve::codec {
namespace {

/// With fewer points, geometry says nothing.
constexpr std::size_t kFewest = 32;

/// x/|z| or y/|z|, the position on the plane of an image.
float on_image(const CloudView& cloud, std::size_t i, int axis) {
  return (axis == 0 ? cloud.x[i] : cloud.y[i]) / std::abs(cloud.z[i]);
}

/// The tangent of the elevation above the plane z = 0, seen from the origin.
float elevation(const CloudView& cloud, std::size_t i) {
  return cloud.z[i] / std::sqrt(cloud.x[i] * cloud.x[i] + cloud.y[i] * cloud.y[i]);
}

/// The lines of an organized cloud: its rows or its columns.
struct Lines {
  std::size_t count, length;  ///< lines, and points of each
  std::size_t line_step, point_step;

  static Lines rows(const CloudView& cloud) { return {cloud.height, cloud.width, cloud.width, 1}; }
  static Lines columns(const CloudView& cloud) { return {cloud.width, cloud.height, 1, cloud.width}; }
};

/// Sums for the variance of values.
struct Variance {
  std::size_t count = 0;
  double sum = 0, squares = 0;

  void add(double value) {
    ++count;
    sum += value;
    squares += value * value;
  }
  /// The sum of the squared differences from the mean.
  double spread() const { return count == 0 ? 0 : std::max(0.0, squares - sum * sum / static_cast<double>(count)); }
};

/// How much of the variance of a value is left within the lines: 0 if it is the same along each line. Looks at some of
/// the lines. Values that are not finite are left out. nullopt if there are too few values, or they do not differ.
template <typename Value>
std::optional<double> share_within(const CloudView& cloud, const Lines& lines, StopCheck& check, Value value) {
  constexpr std::size_t kLines = 48;
  Variance all;
  double within = 0;
  const std::size_t every = std::max<std::size_t>(1, lines.count / kLines);
  for (std::size_t line = every / 2; line < lines.count && !check.after(lines.length); line += every) {
    Variance one;
    for (std::size_t k = 0; k < lines.length; ++k) {
      const std::size_t i = line * lines.line_step + k * lines.point_step;
      const float v = is_point(cloud, i) ? value(i) : NAN;
      if (!std::isfinite(v)) continue;
      one.add(v);
      all.add(v);
    }
    within += one.spread();
  }
  if (all.count < kFewest || all.spread() == 0) return std::nullopt;
  return within / all.spread();
}

constexpr double kConstant = 0.01;  // of the variance may be left within lines

/// Whether x/z or y/z is the same along the lines, and more so than x or y, which is what a raster of heights has.
Agreement are_pixels(const CloudView& cloud, const Lines& lines, int axis, StopCheck& check) {
  constexpr double kExact = 1e-9;
  const auto on_pixels = share_within(cloud, lines, check, [&](std::size_t i) { return on_image(cloud, i, axis); });
  const auto on_raster =
      share_within(cloud, lines, check, [&](std::size_t i) { return axis == 0 ? cloud.x[i] : cloud.y[i]; });
  if (!on_pixels || !on_raster) return Agreement::kUnknown;
  const bool is_flat = *on_pixels < kExact && *on_raster < kExact;
  return *on_pixels <= kConstant && (is_flat || *on_pixels < *on_raster) ? Agreement::kYes : Agreement::kNo;
}

Agreement both(Agreement a, Agreement b) {
  if (a == Agreement::kNo || b == Agreement::kNo) return Agreement::kNo;
  return a == b ? a : Agreement::kUnknown;
}

constexpr float kSteepest = 10;  // Straight above and below, elevations say nothing.

bool are_rings(const CloudView& cloud, const Lines& lines, StopCheck& check) {
  const auto share = share_within(cloud, lines, check, [&](std::size_t i) {
    const float v = elevation(cloud, i);
    return std::abs(v) < kSteepest ? v : NAN;
  });
  return share && *share <= kConstant;
}

/// Values that are (nearly) the same.
struct Cluster {
  float first = 0;
  std::size_t size = 0;
};

/// Divides values, which it sorts, into clusters that are much narrower than the gaps between them. Empty if there are
/// no such clusters: then the values fill their range.
std::vector<Cluster> find_clusters(std::vector<float>& values, StopCheck& check) {
  constexpr std::size_t kMostClusters = 2048;
  constexpr float kNarrow = 0.05F;  // of a mean gap
  constexpr float kInside = 0.08F;  // of the range, by all clusters together
  if (values.size() < kFewest || check.after(16 * values.size())) return {};
  std::ranges::sort(values);
  const float range = values.back() - values.front();
  const auto most = static_cast<float>(std::min(values.size(), kMostClusters));
  std::vector<Cluster> clusters{{values.front(), 1}};
  float inside = 0;
  for (std::size_t i = 1; i < values.size(); ++i) {
    const float step = values[i] - values[i - 1];
    if (step * most > kNarrow * range) {
      clusters.push_back({values[i], 1});
    } else {
      inside += step;
      ++clusters.back().size;
    }
  }
  if (inside > kInside * range) return {};
  return clusters;
}

/// Whether there are some clusters of at least `least_size`, and nearly all values lie in them.
bool are_filled(const std::vector<Cluster>& clusters, std::size_t least_size, double share) {
  constexpr std::size_t kFewestClusters = 4;
  std::size_t all = 0, filled = 0, count = 0;
  for (const Cluster& cluster : clusters) {
    all += cluster.size;
    if (cluster.size < least_size) continue;
    filled += cluster.size;
    ++count;
  }
  return count >= kFewestClusters && static_cast<double>(filled) >= share * static_cast<double>(all);
}

/// Whether the gaps between clusters are multiples of the smallest gap that is common.
bool are_equidistant(const std::vector<Cluster>& clusters) {
  constexpr double kTolerance = 0.1, kShare = 0.95;
  std::vector<float> gaps;
  for (std::size_t i = 1; i < clusters.size(); ++i) gaps.push_back(clusters[i].first - clusters[i - 1].first);
  std::ranges::sort(gaps);
  const double pitch = gaps[gaps.size() / 10];
  const auto is_multiple = [pitch](float gap) {
    const double ratio = gap / pitch;
    return std::abs(ratio - std::round(ratio)) <= kTolerance;
  };
  const auto multiples = static_cast<double>(std::ranges::count_if(gaps, is_multiple));
  return multiples >= kShare * static_cast<double>(gaps.size());
}

/// The values of a sample of the points, as clusters.
template <typename Value>
std::vector<Cluster> clusters_of(const CloudView& cloud, StopCheck& check, Value value) {
  std::vector<float> values;
  for_each_of_sample(cloud, check, [&](std::size_t i) {
    if (const float v = value(i); std::isfinite(v)) values.push_back(v);
  });
  return find_clusters(values, check);
}

bool has_pixel_values(const CloudView& cloud, int axis, StopCheck& check) {
  constexpr std::size_t kLeastSize = 4;
  constexpr double kShare = 0.9;
  const auto pixels = clusters_of(cloud, check, [&](std::size_t i) { return on_image(cloud, i, axis); });
  if (!are_filled(pixels, kLeastSize, kShare) || !are_equidistant(pixels)) return false;
  // A raster of heights has as few values of x and y.
  const auto raster = clusters_of(cloud, check, [&](std::size_t i) { return axis == 0 ? cloud.x[i] : cloud.y[i]; });
  return raster.empty() || raster.size() > pixels.size();
}

/// The sine of the elevation; NaN where it says nothing. The tangent would grow without bounds there, so that all
/// others would lie in one cluster.
float sine_of_elevation(const CloudView& cloud, std::size_t i) {
  const float tangent = elevation(cloud, i);
  return std::abs(tangent) < kSteepest ? tangent / std::sqrt(1 + tangent * tangent) : NAN;
}

/// Whether nearly all rings are circles around the z axis, as those of a body of revolution, and not of a room.
bool are_circles(const CloudView& cloud, StopCheck& check, const std::vector<Cluster>& rings) {
  constexpr float kRound = 0.02F;
  constexpr double kShare = 0.8;
  std::vector<float> least(rings.size(), HUGE_VALF), most(rings.size(), 0);
  check.for_each(0, cloud.size(), [&](std::size_t i) {
    if (!is_point(cloud, i)) return;
    const float sine = sine_of_elevation(cloud, i);
    const auto after = std::ranges::upper_bound(rings, sine, {}, &Cluster::first);
    if (std::isnan(sine) || after == rings.begin()) return;
    const auto ring = static_cast<std::size_t>(after - rings.begin()) - 1;
    const float range = std::sqrt(cloud.x[i] * cloud.x[i] + cloud.y[i] * cloud.y[i]);
    least[ring] = std::min(least[ring], range);
    most[ring] = std::max(most[ring], range);
  });
  std::size_t circles = 0;
  for (std::size_t ring = 0; ring < rings.size(); ++ring)
    circles += most[ring] - least[ring] <= kRound * most[ring] ? 1 : 0;
  return static_cast<double>(circles) >= kShare * static_cast<double>(rings.size());
}

}  // namespace

Extent extent_of(const CloudView& cloud, StopCheck& check) {
  Extent extent;
  check.for_each(0, cloud.size(), [&](std::size_t i) {
    const std::array<float, 3> p{cloud.x[i], cloud.y[i], cloud.z[i]};
    if (!is_finite(p[0], p[1], p[2])) return;
    if (is_origin(cloud, i)) {
      ++extent.zeros;
      return;
    }
    for (std::size_t axis = 0; axis < 3; ++axis) {
      extent.low[axis] = extent.points == 0 ? p[axis] : std::min(extent.low[axis], p[axis]);
      extent.high[axis] = extent.points == 0 ? p[axis] : std::max(extent.high[axis], p[axis]);
    }
    ++extent.points;
    extent.in_front += p[2] > 0 ? 1U : 0U;
    extent.behind += p[2] < 0 ? 1U : 0U;
    constexpr float kWidest = 1.3F;
    extent.wide += std::max(std::abs(p[0]), std::abs(p[1])) > kWidest * std::abs(p[2]) ? 1U : 0U;
  });
  return extent;
}

bool is_behind_origin(const CloudView& cloud, StopCheck& check) {
  std::size_t points = 0, behind = 0;
  const std::size_t most_in_front = cloud.size() / 100;
  for (std::size_t i = 0; i < cloud.size() && points - behind <= most_in_front && !check.after(1); ++i) {
    if (!is_point(cloud, i)) continue;
    ++points;
    behind += cloud.z[i] < 0 ? 1U : 0U;
  }
  return points > 0 && points - behind <= points / 100;
}

Agreement follows_pixels(const CloudView& cloud, StopCheck& check) {
  const Lines rows = Lines::rows(cloud), columns = Lines::columns(cloud);
  const Agreement upright = both(are_pixels(cloud, columns, 0, check), are_pixels(cloud, rows, 1, check));
  if (upright != Agreement::kNo) return upright;
  return both(are_pixels(cloud, rows, 0, check), are_pixels(cloud, columns, 1, check));
}

bool follows_rings(const CloudView& cloud, StopCheck& check) {
  return are_rings(cloud, Lines::rows(cloud), check) || are_rings(cloud, Lines::columns(cloud), check);
}

bool has_pixel_values(const CloudView& cloud, const Extent& extent, StopCheck& check) {
  // A regular grid on a plane of constant z has such values, too.
  constexpr float kFlat = 0.95F;
  const float near = std::min(std::abs(extent.low[2]), std::abs(extent.high[2]));
  const float far = std::max(std::abs(extent.low[2]), std::abs(extent.high[2]));
  return near < kFlat * far && has_pixel_values(cloud, 0, check) && has_pixel_values(cloud, 1, check);
}

bool has_ring_values(const CloudView& cloud, StopCheck& check) {
  constexpr std::size_t kLeastSize = 24;
  constexpr double kShare = 0.95;
  const auto rings = clusters_of(cloud, check, [&](std::size_t i) { return sine_of_elevation(cloud, i); });
  return are_filled(rings, kLeastSize, kShare) && !are_circles(cloud, check, rings);
}

bool has_horizontal_plane(const CloudView& cloud, const Extent& extent, StopCheck& check) {
  constexpr std::size_t kBins = 100, kShare = 5;
  const float low = extent.low[2], range = extent.high[2] - low;
  if (!(range > 0)) return true;
  std::array<std::size_t, kBins + 1> bins{};
  check.for_each(0, cloud.size(), [&](std::size_t i) {
    if (!is_point(cloud, i)) return;
    const float bin = (cloud.z[i] - low) / range * static_cast<float>(kBins);
    if (bin >= 0 && bin <= static_cast<float>(kBins)) ++bins[static_cast<std::size_t>(bin)];
  });
  std::size_t most = 0;
  for (std::size_t bin = 0; bin < kBins; ++bin) most = std::max(most, bins[bin] + bins[bin + 1]);
  return most * kShare >= extent.points;
}

}  // namespace segserve::codec
