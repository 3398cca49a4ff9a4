#include "core/weights/color_geometry_weight.hpp"

#include <algorithm>
#include <bit>
#include <cstdint>

#include "core/base/radix_sort.hpp"
#include "core/base/stop_check.hpp"

namespace segserve {
namespace {

double sum(std::span<const double> values, StopCheck& check) {
  double result = 0;
  check.for_each(0, values.size(), [&](std::size_t i) { result += values[i]; });
  return result;
}

/// The bits of doubles that are not negative are in their order.
std::vector<double> sorted(std::span<const double> values, StopCheck& check) {
  std::vector<std::uint64_t> keys(values.size());
  check.for_each(0, values.size(), [&](std::size_t i) { keys[i] = std::bit_cast<std::uint64_t>(values[i] + 0.0); });
  std::vector<std::uint32_t> order;
  math::sort_order(keys, order, check);
  std::vector<double> result(values.size());
  check.for_each(0, values.size(), [&](std::size_t i) { result[i] = values[order[i]]; });
  return result;
}

double distribution(const std::vector<double>& ascending, double v) {
  const auto not_above = std::ranges::upper_bound(ascending, v) - ascending.begin();
  return static_cast<double>(not_above) / static_cast<double>(ascending.size());
}

}  // namespace

Unification Unification::fixed(double lambda) {
  Unification u;
  u.lambda_ = lambda;
  return u;
}

Unification Unification::adaptive(std::span<const double> color, std::span<const double> geometry,
                                  const StopToken& stop) {
  StopCheck check(stop);
  // The number of edges cancels, so sums serve as means.
  const double c = sum(color, check);
  const double g = sum(geometry, check);
  if (c == 0 || g == 0) return fixed(c == g ? 0.5 : c > 0 ? 1 : 0);
  return fixed(g / (c + g));
}

Unification Unification::equalization(std::span<const double> color, std::span<const double> geometry,
                                      const StopToken& stop) {
  StopCheck check(stop);
  Unification u;
  u.color_ = sorted(color, check);
  u.geometry_ = sorted(geometry, check);
  return u;
}

double Unification::operator()(double color, double geometry) const {
  if (color_.empty()) return lambda_ * color + (1 - lambda_) * geometry;
  return 0.5 * distribution(color_, color) + 0.5 * distribution(geometry_, geometry);
}

}  // namespace segserve
