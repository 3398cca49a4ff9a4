#include "segserve/metric/unification.hpp"

#include <algorithm>
#include <numeric>

namespace segserve {
namespace {

std::vector<double> sorted(std::span<const double> values) {
  std::vector<double> result(values.begin(), values.end());
  std::ranges::sort(result);
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

Unification Unification::adaptive(std::span<const double> color, std::span<const double> geometry) {
  // The number of edges cancels, so sums serve as means.
  const double c = std::accumulate(color.begin(), color.end(), 0.0);
  const double g = std::accumulate(geometry.begin(), geometry.end(), 0.0);
  if (c == 0 || g == 0) return fixed(c == g ? 0.5 : c > 0 ? 1 : 0);
  return fixed(g / (c + g));
}

Unification Unification::equalization(std::span<const double> color, std::span<const double> geometry) {
  Unification u;
  u.color_ = sorted(color);
  u.geometry_ = sorted(geometry);
  return u;
}

double Unification::operator()(double color, double geometry) const {
  if (color_.empty()) return lambda_ * color + (1 - lambda_) * geometry;
  return 0.5 * distribution(color_, color) + 0.5 * distribution(geometry_, geometry);
}

}  // namespace segserve
