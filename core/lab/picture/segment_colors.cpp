// SPDX-License-Identifier: Apache-2.0
#include "core/lab/picture/segment_colors.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

#include "core/lab/picture/picture.hpp"

namespace segserve::picture {
namespace {

using Lab = std::array<double, 3>;

double linear(std::uint8_t byte) {
  const double v = byte / 255.0;
  return v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4);
}

/// Oklab (B. Ottosson, 2020), in which equal steps look equal.
Lab oklab(std::uint32_t rgb) {
  const double r = linear(red(rgb));
  const double g = linear(green(rgb));
  const double b = linear(blue(rgb));
  const double l = std::cbrt(0.4122214708 * r + 0.5363325363 * g + 0.0514459929 * b);
  const double m = std::cbrt(0.2119034982 * r + 0.6806995451 * g + 0.1073969566 * b);
  const double s = std::cbrt(0.0883024619 * r + 0.2817188376 * g + 0.6299787005 * b);
  return {0.2104542553 * l + 0.7936177850 * m - 0.0040720468 * s,
          1.9779984951 * l - 2.4285922050 * m + 0.4505937099 * s,
          0.0259040371 * l + 0.7827717662 * m - 0.8086757660 * s};
}

/// The least difference between a color and those of others; infinite if there are none.
double nearest(std::uint32_t rgb, const std::vector<std::uint32_t>& others) {
  double least = std::numeric_limits<double>::infinity();
  for (const std::uint32_t other : others) least = std::min(least, color_difference(rgb, other));
  return least;
}

}  // namespace

double color_difference(std::uint32_t a, std::uint32_t b) {
  const Lab p = oklab(a);
  const Lab q = oklab(b);
  return std::hypot(p[0] - q[0], p[1] - q[1], p[2] - q[2]);
}

void SegmentColors::update(std::span<const std::uint32_t> labels, std::span<const LabelPair> neighbors) {
  std::map<std::uint32_t, std::vector<std::uint32_t>> around;
  for (const auto& [a, b] : neighbors) {
    around[a].push_back(b);
    around[b].push_back(a);
  }
  std::vector<std::uint32_t> order(labels.begin(), labels.end());
  std::ranges::stable_partition(order, [&](std::uint32_t label) { return color_.contains(label); });
  for (const std::uint32_t label : order) spare_ = std::max(spare_, label);

  constexpr std::uint32_t kCandidates = 64;
  std::map<std::uint32_t, std::uint32_t> chosen;
  for (const std::uint32_t label : order) {
    std::vector<std::uint32_t> taken;
    for (const std::uint32_t other : around[label]) {
      if (const auto at = chosen.find(other); at != chosen.end()) taken.push_back(at->second);
    }
    std::uint32_t best = (*this)(label);
    double best_difference = nearest(best, taken);
    for (std::uint32_t i = 1; i <= kCandidates && best_difference < kLeastColorDifference; ++i) {
      const std::uint32_t candidate = segment_color(spare_ + i);
      const double difference = nearest(candidate, taken);
      if (difference <= best_difference) continue;
      best = candidate;
      best_difference = difference;
    }
    chosen[label] = best;
  }
  for (const auto& [label, rgb] : chosen) color_[label] = rgb;
}

std::uint32_t SegmentColors::operator()(std::uint32_t label) const {
  const auto at = color_.find(label);
  return at == color_.end() ? segment_color(label) : at->second;
}

std::vector<std::uint32_t> labels_by_size(const Raster& raster, std::span<const std::uint32_t> labels) {
  std::map<std::uint32_t, std::size_t> pixels;
  for (const std::uint32_t point : raster.point) {
    if (point != Raster::kNoPoint && labels[point] != 0) ++pixels[labels[point]];
  }
  std::vector<std::uint32_t> order;
  order.reserve(pixels.size());
  for (const auto& [label, count] : pixels) order.push_back(label);
  std::ranges::stable_sort(order, [&](std::uint32_t a, std::uint32_t b) { return pixels[a] > pixels[b]; });
  return order;
}

std::vector<SegmentColors::LabelPair> label_neighbors(const Raster& raster, std::span<const std::uint32_t> labels) {
  std::vector<SegmentColors::LabelPair> pairs;
  const auto label = [&](std::size_t x, std::size_t y) {
    const std::uint32_t point = raster.point[y * raster.width + x];
    return point == Raster::kNoPoint ? 0U : labels[point];
  };
  constexpr std::array<std::array<std::size_t, 2>, 4> kSteps{{{1, 0}, {2, 0}, {0, 1}, {0, 2}}};
  for (std::size_t y = 0; y < raster.height; ++y) {
    for (std::size_t x = 0; x < raster.width; ++x) {
      const std::uint32_t own = label(x, y);
      if (own == 0) continue;
      for (const auto& [dx, dy] : kSteps) {
        if (x + dx >= raster.width || y + dy >= raster.height) continue;
        const std::uint32_t other = label(x + dx, y + dy);
        if (other == 0 || other == own) continue;
        const SegmentColors::LabelPair pair = std::minmax(own, other);
        if (pairs.empty() || pairs.back() != pair) pairs.push_back(pair);
      }
    }
  }
  std::ranges::sort(pairs);
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  return pairs;
}

}  // namespace segserve::picture
