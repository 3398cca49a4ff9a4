// SPDX-License-Identifier: Apache-2.0
#include "core/scale/cloud_sampling.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <tuple>
#include <utility>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "absl/container/flat_hash_set.h"
#include "core/math/elementary.hpp"
#include "core/math/random.hpp"
#include "core/math/symmetric_matrix3.hpp"
#include "core/scale/quantile.hpp"
#include "core/voxels/point_selections.hpp"

namespace segserve {
namespace {

constexpr std::size_t kFewestPoints = 64;  // fewer tell nothing
/// The mean number of different places of points in a voxel that is enough, even if voxels have few neighbors: the
/// sweep of a LiDAR has sparse parts, which do not decide alone, and small objects are all border.
constexpr double kManyPlaces = 4.5;

/// A cell of a cubic grid. Coordinates end at 10^9 cells from the origin.
struct Cell {
  std::int32_t x, y, z;
  bool operator==(const Cell&) const = default;
  template <typename H>
  friend H AbslHashValue(H h, const Cell& c) {  // NOLINT(readability-identifier-naming): Abseil looks for it
    return H::combine(std::move(h), c.x, c.y, c.z);
  }
};

/// A hash that is the same in every process, unlike that of absl.
std::uint64_t hash_of(std::uint32_t x, std::uint32_t y, std::uint32_t z) {
  return mix(mix((std::uint64_t{x} << 32U) | y) + z);
}
std::uint64_t hash_of(const Cell& c) {
  return hash_of(static_cast<std::uint32_t>(c.x), static_cast<std::uint32_t>(c.y), static_cast<std::uint32_t>(c.z));
}
/// Whether a hash is among this share of all.
bool is_among(std::uint64_t hash, double share) { return unit_interval(hash) < share; }

Cell cell_at(const Vec3& p, double edge) {
  const auto index = [edge](double meters) {
    constexpr double kMost = 1'000'000'000;
    return math::floor_to_int(std::clamp(meters / edge, -kMost, kMost));
  };
  return {index(p.x), index(p.y), index(p.z)};
}

class SamplingEstimate {
 public:
  SamplingEstimate(const FrameContext& frame, StopCheck& check)
      : cloud_(frame.cloud), selections_(frame.options, frame.view()), check_(check) {}

  CloudSampling run(double edge) {
    thin_out();
    if (points_ < kFewestPoints || thin_.size() < kFewestPoints || check_.stopped()) return {};
    CloudSampling sampling;
    sampling.extent = extent();
    if (sampling.extent <= 0) return {};
    if (sampling.extent <= edge) return sampling;  // No larger voxels would have more neighbors.
    choose_blocks(sampling.extent, edge);
    gather_sample();
    if (sample_.size() < kFewestPoints || check_.stopped()) return sampling;
    sampling.connected_edge = connected_edge(edge, finest_edge(sampling.extent, edge));
    if (sampling.connected_edge > 0) sampling.noise = noise(5 * sampling.connected_edge);
    return sampling;
  }

 private:
  template <typename Each>
  void for_each_point(Each&& each) {
    for (std::size_t first = 0, end = 0; first < cloud_.size() && !check_.stopped(); first = end) {
      const PointSelections::Part& part = selections_.at(first);
      end = std::min(part.end, cloud_.size());
      check_.for_each(first, end, [&](std::size_t i) {
        const float x = cloud_.x[i], y = cloud_.y[i], z = cloud_.z[i];
        if (is_finite(x, y, z) && part.selection.selects(x, y, z)) each(x, y, z);
      });
    }
  }

  /// Takes points evenly from the whole cloud. Those that it takes depend on their coordinates alone.
  void thin_out() {
    constexpr double kWanted = 16384;
    const double share = kWanted / static_cast<double>(cloud_.size());
    const auto bits = [](float v) { return std::bit_cast<std::uint32_t>(v); };
    for_each_point([&](float x, float y, float z) {
      ++points_;
      if (is_among(hash_of(bits(x), bits(y), bits(z)), share)) thin_.push_back({x, y, z});
    });
  }

  double extent() const {
    Vec3 size;
    for (double Vec3::*axis : {&Vec3::x, &Vec3::y, &Vec3::z}) {
      std::vector<double> values;
      values.reserve(thin_.size());
      for (const Vec3& p : thin_) values.push_back(p.*axis);
      size.*axis = quantile(values, 0.95) - quantile(values, 0.05);
    }
    return norm(size);
  }

  /// Sets the edge of the blocks of which a few are looked at closely, such that each holds hundreds of points.
  void choose_blocks(double extent, double usual) {
    constexpr double kPointsOfBlock = 512, kThinPointsOfBlock = 4, kVoxelsOfBlock = 16;
    const auto thin = static_cast<double>(thin_.size());
    block_edge_ = 2 * extent;
    while (!check_.stopped()) {
      const double edge = 0.5 * block_edge_;
      if (edge < kVoxelsOfBlock * usual && extent > usual) break;
      const std::size_t blocks = count_blocks(edge);
      const auto count = static_cast<double>(blocks);
      if (static_cast<double>(points_) < kPointsOfBlock * count || thin < kThinPointsOfBlock * count) break;
      block_edge_ = edge;
      blocks_ = blocks;
      if (blocks_ > 1 && block_edge_ < 1e-6 * extent) break;  // Many points at one place.
    }
  }

  std::size_t count_blocks(double edge) {
    absl::flat_hash_set<Cell> blocks;
    check_.for_each(0, thin_.size(), [&](std::size_t i) { blocks.insert(cell_at(thin_[i], edge)); });
    return blocks.size();
  }

  void gather_sample() {
    constexpr std::size_t kMost = 131072;
    constexpr int kTries = 4;
    double wanted = 32768;
    for (int i = 0; i < kTries && !check_.stopped(); ++i) {
      share_ = wanted / static_cast<double>(points_);
      sample_.clear();
      for_each_point([&](float x, float y, float z) {
        const Vec3 p{x, y, z};
        if (sample_.size() <= kMost && is_in_sample(p)) sample_.push_back(p);
      });
      if (sample_.size() > kMost) {
        block_edge_ *= 0.5;  // Most points lie in one block.
      } else if (sample_.size() < kFewestPoints && share_ < 1) {
        wanted *= 16;
      } else {
        return;
      }
    }
    sample_.clear();
  }

  bool is_in_sample(const Vec3& p) const { return share_ >= 1 || is_among(hash_of(cell_at(p, block_edge_)), share_); }

  /// Tries the usual edge and its multiples by powers of 2^(1/4). A cloud for which the usual edge fits gets that, or a
  /// finer one down to `finest`.
  double connected_edge(double usual, double finest) {
    constexpr double kDensePoints = 2;    // which voxels finer than the usual ones must hold, in the mean
    constexpr double kMostLoose = 0.045;  // share of points in voxels with few neighbors
    constexpr double kMostTorn = 0.12;    // share of points in voxels beside a gap
    constexpr int kMostSteps = 64;
    const auto is_connected = [&](double edge, double points) {
      const Connectivity c = connectivity_at(edge);
      return c.places_of_voxel >= kManyPlaces ||
             (c.loose <= kMostLoose && c.torn <= kMostTorn && c.points_of_voxel >= points);
    };
    int n = 0;
    if (is_connected(usual, 0)) {
      while (n > -kMostSteps && multiple(usual, n - 1) >= finest &&
             is_connected(multiple(usual, n - 1), kDensePoints)) {
        --n;
      }
      return multiple(usual, n);
    }
    // Begins well below the edge at which a voxel would hold a point if each block held an even square of them.
    const double even = block_edge_ * std::sqrt(static_cast<double>(blocks_) / static_cast<double>(points_));
    while (n < kMostSteps && multiple(usual, n + 1) < 0.5 * even) ++n;
    do ++n;
    while (n < kMostSteps && !check_.stopped() && !is_connected(multiple(usual, n), 0));
    return multiple(usual, n);
  }

  /// edge * 2^(n / 4)
  static double multiple(double edge, int n) {
    constexpr std::array<double, 4> kRoots = {1, 1.1892071150027210667, 1.4142135623730950488, 1.6817928305074290861};
    const int octave = math::floor_to_int(0.25 * n);
    return std::ldexp(edge * kRoots[static_cast<std::size_t>(n - 4 * octave)], octave);
  }

  struct Connectivity {
    double points_of_voxel = 0, places_of_voxel = 0, loose = 1, torn = 1;
  };

  using Voxels = absl::flat_hash_map<Cell, std::uint32_t>;

  Connectivity connectivity_at(double edge) {
    constexpr double kQueries = 1024;
    Voxels voxels;
    check_.for_each(0, sample_.size(), [&](std::size_t i) { ++voxels[cell_at(sample_[i], edge)]; });
    const double share = kQueries / static_cast<double>(voxels.size());
    std::uint64_t points = 0, loose = 0, torn = 0;
    for (const auto& [cell, count] : voxels) {
      if (check_.after(1) || !is_among(hash_of(cell), share)) continue;
      const Surroundings around = surroundings_of(voxels, cell, edge);
      if (around == Surroundings::kUnknown) continue;
      points += count;
      if (around == Surroundings::kLoose) loose += count;
      if (around == Surroundings::kTorn) torn += count;
    }
    const double mean = static_cast<double>(sample_.size()) / static_cast<double>(voxels.size());
    const double places = mean_of_places(edge, voxels.size());
    if (points == 0) return {mean, places, 1, 1};  // voxels as large as the blocks of the sample
    const auto share_of_points = [points](std::uint64_t part) {
      return static_cast<double>(part) / static_cast<double>(points);
    };
    return {mean, places, share_of_points(loose), share_of_points(torn)};
  }

  /// The number of different places, cells of a 32nd of the edge, that a voxel holds in the mean.
  double mean_of_places(double edge, std::size_t voxels) {
    absl::flat_hash_set<Cell> places;
    check_.for_each(0, sample_.size(), [&](std::size_t i) { places.insert(cell_at(sample_[i], edge / 32)); });
    return static_cast<double>(places.size()) / static_cast<double>(voxels);
  }

  enum class Surroundings : std::uint8_t {
    kUnknown,  // the sample does not hold all neighbors
    kLoose,    // there are few neighbors
    kTorn,  // there is a gap of one empty layer, as beside voxels that are a little finer than a regular grid of points
    kClosed,
  };

  Surroundings surroundings_of(const Voxels& voxels, const Cell& cell, double edge) {
    constexpr int kFewNeighbors = 5;
    int neighbors = 0;
    std::array<bool, 6> beside{};  // whether there is a neighbor on the side of -x, +x, -y, +y, -z, +z
    for (int dz = -1; dz <= 1; ++dz) {
      for (int dy = -1; dy <= 1; ++dy) {
        for (int dx = -1; dx <= 1; ++dx) {
          const Cell other{cell.x + dx, cell.y + dy, cell.z + dz};
          if (check_.after(1) || other == cell) continue;
          if (voxels.contains(other)) {
            ++neighbors;
            const std::array<int, 3> d{dx, dy, dz};
            for (std::size_t axis = 0; axis < 3; ++axis) {
              if (d[axis] != 0) beside[2 * axis + static_cast<std::size_t>(d[axis] > 0)] = true;
            }
          } else if (!is_in_sample({(other.x + 0.5) * edge, (other.y + 0.5) * edge, (other.z + 0.5) * edge})) {
            return Surroundings::kUnknown;
          }
        }
      }
    }
    if (neighbors < kFewNeighbors) return Surroundings::kLoose;
    for (std::size_t side = 0; side < beside.size(); ++side) {
      if (!beside[side] && is_beyond_gap(voxels, cell, side)) return Surroundings::kTorn;
    }
    return Surroundings::kClosed;
  }

  /// Whether a voxel is straight across the empty layer on this side.
  bool is_beyond_gap(const Voxels& voxels, const Cell& cell, std::size_t side) {
    const int step = side % 2 == 0 ? -2 : 2;
    for (int a = -1; a <= 1; ++a) {
      for (int b = -1; b <= 1; ++b) {
        if (check_.after(1)) return false;
        Cell other = cell;
        (side < 2 ? other.x : side < 4 ? other.y : other.z) += step;
        (side < 2 ? other.y : other.x) += a;
        (side < 4 ? other.z : other.y) += b;
        if (voxels.contains(other)) return true;
      }
    }
    return false;
  }

  double noise(double edge) {
    constexpr std::size_t kFewestCells = 16, kFewestPointsOfCell = 9;
    std::vector<std::pair<std::uint64_t, std::uint32_t>> order(sample_.size());
    check_.for_each(0, sample_.size(), [&](std::size_t i) {
      order[i] = {hash_of(cell_at(sample_[i], edge)), static_cast<std::uint32_t>(i)};
    });
    // Sums of doubles depend on their order, so points of a cell are sorted by their coordinates.
    std::ranges::sort(order, [&](const auto& a, const auto& b) {
      const auto key = [&](const auto& o) {
        const Vec3& p = sample_[o.second];
        return std::make_tuple(o.first, p.x, p.y, p.z);
      };
      return key(a) < key(b);
    });
    std::vector<double> deviations;
    for (std::size_t begin = 0, end = 0; begin < order.size() && !check_.after(1); begin = end) {
      while (end < order.size() && order[end].first == order[begin].first) ++end;
      if (end - begin < kFewestPointsOfCell) continue;
      const auto n = static_cast<double>(end - begin);
      Vec3 mean;
      for (std::size_t i = begin; i < end; ++i) mean += sample_[order[i].second];
      mean = (1 / n) * mean;
      Symmetric3 scatter;
      for (std::size_t i = begin; i < end; ++i) scatter += outer(sample_[order[i].second] - mean);
      const Vec3 normal = smallest_eigenvector(scatter);
      if (normal == Vec3{}) continue;
      double squares = 0;
      for (std::size_t i = begin; i < end; ++i) {
        const double distance = dot(normal, sample_[order[i].second] - mean);
        squares += distance * distance;
      }
      deviations.push_back(std::sqrt(squares / (n - 3)));
    }
    return deviations.size() < kFewestCells ? 0 : quantile(deviations, 0.4);
  }

  const CloudView& cloud_;
  const PointSelections selections_;
  StopCheck& check_;
  std::size_t points_ = 0;    // finite and selected
  std::vector<Vec3> thin_;    // some points from everywhere
  double block_edge_ = 0;     // meters
  std::size_t blocks_ = 1;    // occupied ones
  double share_ = 1;          // of the blocks that are in the sample
  std::vector<Vec3> sample_;  // all points of some blocks
};

}  // namespace

double finest_edge(double extent, double edge) {
  constexpr double kVoxelsOfExtent = 100, kSmallest = 0.001;
  return std::min(edge, std::max(kSmallest, extent / kVoxelsOfExtent));
}

CloudSampling estimate_cloud_sampling(const FrameContext& frame, double edge, StopCheck& check) {
  return SamplingEstimate(frame, check).run(edge);
}

}  // namespace segserve
