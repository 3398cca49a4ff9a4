// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "segserve/stop_token.hpp"

namespace segserve {

/// The transformations T_C and T_G (section 2.2.3 of the paper) that bring the dissimilarities of color and of geometry
/// to one scale.
class ColorGeometryWeight {
 public:
  /// T_C(a) = lambda a and T_G(b) = (1 - lambda) b.
  static ColorGeometryWeight fixed(double lambda);

  /// Adaptive Lambda: the lambda mu_G / (mu_C + mu_G), for which T_C and T_G have the same mean over the initial edges.
  /// It is 1/2 if both means are 0. If only one mean is 0, as that of color is in a cloud without color, the other
  /// dissimilarity decides alone; by the formula all weights would be 0. CANCELLED, DEADLINE_EXCEEDED.
  static absl::StatusOr<ColorGeometryWeight> adaptive(std::span<const double> color, std::span<const double> geometry,
                                                      const StopToken& stop = {});

  /// Equalization: half the empirical distribution function F, where F(v) is the share of the initial edges whose
  /// dissimilarity is at most v. CANCELLED, DEADLINE_EXCEEDED.
  static absl::StatusOr<ColorGeometryWeight> equalization(std::span<const double> color,
                                                          std::span<const double> geometry, const StopToken& stop = {});

  /// T_C(color) + T_G(geometry)
  double operator()(double color, double geometry) const;

  double lambda() const { return lambda_; }

 private:
  ColorGeometryWeight(double lambda, std::vector<double> color, std::vector<double> geometry)
      : lambda_(lambda), color_(std::move(color)), geometry_(std::move(geometry)) {}

  double lambda_;
  std::vector<double> color_, geometry_;  // ascending; empty unless this is Equalization
};

}  // namespace segserve
