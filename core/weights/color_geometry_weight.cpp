// SPDX-License-Identifier: Apache-2.0
#include "core/weights/color_geometry_weight.hpp"

#include <algorithm>
#include <bit>
#include <cstdint>

#include "core/base/radix_sort.hpp"
#include "core/base/status_macros.hpp"
#include "core/base/stop_check.hpp"

namespace segserve {
namespace {

double sum(std::span<const double> values, StopCheck& check) {
  double result = 0;
  check.for_each(0, values.size(), [&](std::size_t i) { result += values[i]; });
  return result;
}

/// Sorts by the bits, whose order is that of the values, because none of these is negative.
std::vector<double> sorted(std::span<const double> values, StopCheck& check) {
  std::vector<std::uint64_t> keys(values.size());
  check.for_each(0, values.size(), [&](std::size_t i) { keys[i] = std::bit_cast<std::uint64_t>(values[i] + 0.0); });
  std::vector<std::uint32_t> order;
  math::sort_order(keys, order, check);
  std::vector<double> result(values.size());
  check.for_each(0, values.size(), [&](std::size_t i) { result[i] = values[order[i]]; });
  return result;
}

/// The empirical distribution function of `ascending` at v.
double distribution(const std::vector<double>& ascending, double v) {
  const auto not_above = std::ranges::upper_bound(ascending, v) - ascending.begin();
  return static_cast<double>(not_above) / static_cast<double>(ascending.size());
}

}  // namespace

ColorGeometryWeight ColorGeometryWeight::fixed(double lambda) { return {lambda, {}, {}}; }

absl::StatusOr<ColorGeometryWeight> ColorGeometryWeight::adaptive(std::span<const double> color,
                                                                  std::span<const double> geometry,
                                                                  const StopToken& stop) {
  StopCheck check(stop);
  // The number of edges cancels, so that sums serve as means.
  const double c = sum(color, check);
  const double g = sum(geometry, check);
  RETURN_IF_ERROR(check.status());
  if (c == 0 || g == 0) return fixed(c == g ? 0.5 : c > 0 ? 1 : 0);
  return fixed(g / (c + g));
}

absl::StatusOr<ColorGeometryWeight> ColorGeometryWeight::equalization(std::span<const double> color,
                                                                      std::span<const double> geometry,
                                                                      const StopToken& stop) {
  StopCheck check(stop);
  ColorGeometryWeight weight(0.5, sorted(color, check), sorted(geometry, check));
  RETURN_IF_ERROR(check.status());
  return weight;
}

double ColorGeometryWeight::operator()(double color, double geometry) const {
  if (color_.empty()) return lambda_ * color + (1 - lambda_) * geometry;
  return 0.5 * distribution(color_, color) + 0.5 * distribution(geometry_, geometry);
}

}  // namespace segserve
