#include "segserve/segment_statistics.hpp"

#include <algorithm>
#include <limits>
#include <utility>

#include "absl/numeric/int128.h"
#include "core/base/parallel_parts.hpp"
#include "core/base/status_macros.hpp"
#include "core/base/stop_check.hpp"
#include "core/math/symmetric_matrix3.hpp"
#include "fmt/format.h"

namespace segserve {
namespace {

constexpr std::size_t kRun = 2048;      // most points of one label that are summed up at a time
constexpr double kGridSteps = 1 << 26;  // of a segment's own grid: squares of kRun coordinates add up to less than 2^64

/// What the first pass gathers; all of it is the same for any order of the points.
struct Bounds {
  std::uint32_t points = 0;
  std::array<float, 3> low, high;
  std::array<std::uint64_t, 3> color{};
  bool finite = true;

  Bounds() {
    low.fill(std::numeric_limits<float>::infinity());
    high.fill(-std::numeric_limits<float>::infinity());
  }
  void add(const Bounds& o) {
    points += o.points;
    for (std::size_t k = 0; k < 3; ++k) {
      low[k] = std::min(low[k], o.low[k]);
      high[k] = std::max(high[k], o.high[k]);
      color[k] += o.color[k];
    }
    finite = finite && o.finite;
  }
};

/// Whole numbers: the position of a point in the grid that divides its segment's largest extent by kGridSteps.
class Grid {
 public:
  Grid() = default;
  explicit Grid(const Bounds& bounds) : low_{double{bounds.low[0]}, double{bounds.low[1]}, double{bounds.low[2]}} {
    double extent = 0;
    for (std::size_t k = 0; k < 3; ++k) extent = std::max(extent, double{bounds.high[k]} - double{bounds.low[k]});
    if (extent > 0) steps_per_metre_ = kGridSteps / extent, metres_per_step_ = extent / kGridSteps;
  }

  std::uint64_t x(float metres) const { return step(metres, low_.x); }
  std::uint64_t y(float metres) const { return step(metres, low_.y); }
  std::uint64_t z(float metres) const { return step(metres, low_.z); }
  Vec3 metres(const Vec3& steps) const { return low_ + metres_per_step_ * steps; }

 private:
  std::uint64_t step(float metres, double low) const {
    const double steps = (double{metres} - low) * steps_per_metre_;
    constexpr double kHalf = 0.5;  // rounds to the nearest: steps are not negative
    return static_cast<std::uint32_t>(static_cast<std::int32_t>(steps + kHalf));
  }

  Vec3 low_;
  double steps_per_metre_ = 0, metres_per_step_ = 0;
};

/// Sums of a segment's grid coordinates and of their products: exact.
struct Moments {
  std::uint64_t x = 0, y = 0, z = 0;
  absl::uint128 xx = 0, xy = 0, xz = 0, yy = 0, yz = 0, zz = 0;

  void add(const Moments& o) {
    x += o.x, y += o.y, z += o.z;
    xx += o.xx, xy += o.xy, xz += o.xz, yy += o.yy, yz += o.yz, zz += o.zz;
  }
};

/// Least and greatest coordinate of a segment's points along its axes, from its centroid.
struct Reach {
  std::array<double, 3> low, high;

  Reach() {
    low.fill(std::numeric_limits<double>::infinity());
    high.fill(-std::numeric_limits<double>::infinity());
  }
  void add(const Reach& o) {
    for (std::size_t k = 0; k < 3; ++k) low[k] = std::min(low[k], o.low[k]), high[k] = std::max(high[k], o.high[k]);
  }
};

/// The points by segment, in runs of one label.
class Passes {
 public:
  Passes(std::span<const std::uint32_t> labels, std::uint32_t segments, Executor& executor, const StopToken& stop)
      : labels_(labels), segments_(segments), executor_(executor), stop_(stop) {}

  /// One pass: of_run(s, begin, end) gives the part that points [begin, end) have in the sum of segment s + 1.
  template <typename Sum, typename OfRun>
  absl::StatusOr<std::vector<Sum>> sum(OfRun&& of_run) const {
    std::vector<std::vector<Sum>> parts(executor_.threads(), std::vector<Sum>(segments_));
    const auto sum_part = [&](std::vector<Sum>& sums, std::size_t begin, std::size_t end, StopCheck& check) {
      for (std::size_t i = begin; i < end;) {
        const std::size_t last = std::min(i + kRun, end);
        if (check.after(last - i)) return;
        while (i < last) {
          const std::size_t run = i;
          while (i < last && labels_[i] == labels_[run]) ++i;
          const std::uint32_t s = labels_[run] - 1;  // beyond all segments for label 0
          if (s < segments_) sums[s].add(of_run(s, run, i));
        }
      }
    };
    RETURN_IF_ERROR(parallel_parts(executor_, stop_, labels_.size(),
                                   [&](unsigned part, std::size_t begin, std::size_t end, StopCheck& check) {
                                     sum_part(parts[part], begin, end, check);
                                   }));
    StopCheck check(stop_);
    for (std::size_t part = 1; part < parts.size(); ++part) {
      check.for_each(0, segments_, [&](std::size_t s) { parts[0][s].add(parts[part][s]); });
    }
    RETURN_IF_ERROR(check.status());
    return std::move(parts[0]);
  }

 private:
  std::span<const std::uint32_t> labels_;
  std::uint32_t segments_;
  Executor& executor_;
  const StopToken& stop_;
};

/// Widens [low, high] to these values. In lanes, as the compiler vectorises no reduction to a float.
template <typename Real>
void widen(std::span<const Real> values, Real& low, Real& high) {
  constexpr std::size_t kLanes = 4;
  std::array<Real, kLanes> least, most;
  least.fill(low), most.fill(high);
  std::size_t i = 0;
  for (; i + kLanes <= values.size(); i += kLanes) {
    for (std::size_t k = 0; k < kLanes; ++k) {
      const Real v = values[i + k];
      least[k] = v < least[k] ? v : least[k];
      most[k] = v > most[k] ? v : most[k];
    }
  }
  for (; i < values.size(); ++i) {
    least[0] = std::min(least[0], values[i]);
    most[0] = std::max(most[0], values[i]);
  }
  low = *std::ranges::min_element(least);
  high = *std::ranges::max_element(most);
}

Bounds bounds_of_run(const CloudView& cloud, std::size_t begin, std::size_t end) {
  Bounds b;
  const std::size_t count = end - begin;
  b.points = static_cast<std::uint32_t>(count);
  widen(cloud.x.subspan(begin, count), b.low[0], b.high[0]);
  widen(cloud.y.subspan(begin, count), b.low[1], b.high[1]);
  widen(cloud.z.subspan(begin, count), b.low[2], b.high[2]);
  std::int32_t finite = 1;
  for (std::size_t i = begin; i < end; ++i) {
    finite &= static_cast<std::int32_t>(is_finite(cloud.x[i], cloud.y[i], cloud.z[i]));
  }
  b.finite = finite != 0;
  if (cloud.has_color()) {
    std::uint32_t sum_red = 0, sum_green = 0, sum_blue = 0;
    for (std::size_t i = begin; i < end; ++i) {
      const std::uint32_t rgb = cloud.rgb[i];
      sum_red += red(rgb), sum_green += green(rgb), sum_blue += blue(rgb);
    }
    b.color = {sum_red, sum_green, sum_blue};
  }
  return b;
}

Moments moments_of_run(const CloudView& cloud, const Grid& grid, std::size_t begin, std::size_t end) {
  std::uint64_t sx = 0, sy = 0, sz = 0, xx = 0, xy = 0, xz = 0, yy = 0, yz = 0, zz = 0;
  for (std::size_t i = begin; i < end; ++i) {
    const std::uint64_t x = grid.x(cloud.x[i]), y = grid.y(cloud.y[i]), z = grid.z(cloud.z[i]);
    sx += x, sy += y, sz += z;
    xx += x * x, xy += x * y, xz += x * z, yy += y * y, yz += y * z, zz += z * z;
  }
  return {sx, sy, sz, xx, xy, xz, yy, yz, zz};
}

Reach reach_of_run(const CloudView& cloud, const SegmentStatistics& segment, std::size_t begin, std::size_t end) {
  Reach reach;
  const std::size_t count = end - begin;
  std::array<std::array<double, kRun>, 3> along;
  const auto& [first, second, third] = segment.box.axes;
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3 d{double{cloud.x[begin + i]} - segment.centroid.x, double{cloud.y[begin + i]} - segment.centroid.y,
                 double{cloud.z[begin + i]} - segment.centroid.z};
    along[0][i] = dot(first, d), along[1][i] = dot(second, d), along[2][i] = dot(third, d);
  }
  for (std::size_t k = 0; k < 3; ++k) {
    widen(std::span<const double>(along[k]).first(count), reach.low[k], reach.high[k]);
  }
  return reach;
}

/// The points' covariance but for a factor, which leaves its axes as they are.
Symmetric3 covariance(const Moments& m, std::uint32_t points) {
  const auto entry = [points](absl::uint128 product, std::uint64_t a, std::uint64_t b) {
    const auto value = static_cast<absl::int128>(product * points) - static_cast<absl::int128>(absl::uint128{a} * b);
    return static_cast<double>(value);
  };
  return {entry(m.xx, m.x, m.x), entry(m.xy, m.x, m.y), entry(m.xz, m.x, m.z),
          entry(m.yy, m.y, m.y), entry(m.yz, m.y, m.z), entry(m.zz, m.z, m.z)};
}

Vec3 mean(const Vec3& sum, std::uint32_t points) {
  const double n = points;
  return {sum.x / n, sum.y / n, sum.z / n};
}

template <typename Integer>
Vec3 to_vec3(Integer x, Integer y, Integer z) {
  return {static_cast<double>(x), static_cast<double>(y), static_cast<double>(z)};
}

void close_box(const Reach& reach, SegmentStatistics& segment) {
  OrientedBox& box = segment.box;
  box.center = segment.centroid;
  for (std::size_t k = 0; k < 3; ++k) box.center += (0.5 * (reach.low[k] + reach.high[k])) * box.axes[k];
  const auto half = [&reach](std::size_t k) { return 0.5 * (reach.high[k] - reach.low[k]); };
  box.half_extents = {half(0), half(1), half(2)};
}

absl::Status check_input(const CloudView& cloud, std::span<const std::uint32_t> labels, std::uint32_t segments) {
  if (absl::Status status = check_shape(cloud); !status.ok()) return status;
  if (labels.size() == cloud.size() && segments <= cloud.size()) return absl::OkStatus();
  return absl::InvalidArgumentError(
      fmt::format("{} labels of {} segments for {} points", labels.size(), segments, cloud.size()));
}

absl::Status not_finite(const CloudView& cloud, std::span<const std::uint32_t> labels, std::uint32_t segments) {
  std::size_t i = 0;
  while (is_finite(cloud.x[i], cloud.y[i], cloud.z[i]) || labels[i] == 0 || labels[i] > segments) ++i;
  return absl::InvalidArgumentError(fmt::format("point {} is not finite, but has label {}, not 0", i, labels[i]));
}

}  // namespace

absl::StatusOr<std::vector<SegmentStatistics>> describe_segments(const CloudView& cloud,
                                                                 std::span<const std::uint32_t> labels,
                                                                 std::uint32_t segments, unsigned threads,
                                                                 const StopToken& stop) {
  if (absl::Status status = check_input(cloud, labels, segments); !status.ok()) return status;
  if (segments == 0) return std::vector<SegmentStatistics>();
  Executor executor(threads);
  const Passes passes(labels, segments, executor, stop);
  ASSIGN_OR_RETURN(const std::vector<Bounds> bounds,
                   passes.sum<Bounds>([&](std::uint32_t, std::size_t begin, std::size_t end) {
                     return bounds_of_run(cloud, begin, end);
                   }));
  if (!std::ranges::all_of(bounds, &Bounds::finite)) return not_finite(cloud, labels, segments);

  const std::vector<Grid> grids(bounds.begin(), bounds.end());
  ASSIGN_OR_RETURN(const std::vector<Moments> moments,
                   passes.sum<Moments>([&](std::uint32_t s, std::size_t begin, std::size_t end) {
                     return moments_of_run(cloud, grids[s], begin, end);
                   }));

  std::vector<SegmentStatistics> result(segments);
  StopCheck check(stop);
  check.for_each(0, segments, [&](std::size_t s) {
    const Bounds& b = bounds[s];
    SegmentStatistics& segment = result[s];
    segment.points = b.points;
    if (b.points == 0) return;
    const Moments& m = moments[s];
    segment.centroid = grids[s].metres(mean(to_vec3(m.x, m.y, m.z), b.points));
    segment.box.axes = principal_axes(covariance(m, b.points));
    if (cloud.has_color()) segment.color = mean(to_vec3(b.color[0], b.color[1], b.color[2]), b.points);
  });
  RETURN_IF_ERROR(check.status());

  ASSIGN_OR_RETURN(const std::vector<Reach> reach,
                   passes.sum<Reach>([&](std::uint32_t s, std::size_t begin, std::size_t end) {
                     return reach_of_run(cloud, result[s], begin, end);
                   }));
  check.for_each(0, segments, [&](std::size_t s) {
    if (result[s].points > 0) close_box(reach[s], result[s]);
  });
  RETURN_IF_ERROR(check.status());
  return result;
}

void set_normals(std::span<const Vec3> supervoxel_normals, std::span<const std::uint32_t> segment_of_leaf,
                 std::span<SegmentStatistics> statistics, const StopToken& stop) {
  constexpr double kNothing = 1e-6;  // unit vectors that cancel out leave a sum of rounding errors
  StopCheck check(stop);
  std::vector<Vec3> sums(statistics.size());
  check.for_each(0, supervoxel_normals.size(), [&](std::size_t leaf) {
    const std::uint32_t s = segment_of_leaf[leaf] - 1;
    if (s < sums.size()) sums[s] += supervoxel_normals[leaf];
  });
  check.for_each(0, sums.size(), [&](std::size_t s) {
    statistics[s].normal = norm(sums[s]) > kNothing ? std::optional(unit(sums[s])) : std::nullopt;
  });
}

}  // namespace segserve
