#pragma once

#include <span>
#include <vector>

#include "segserve/stop_token.hpp"

namespace segserve {

/// The transformations T_C and T_G (section 2.2.3) that bring colour and geometry to one scale. If stopped,
/// what was learnt is useless.
class Unification {
 public:
  /// T_C(a) = lambda a, T_G(b) = (1 - lambda) b.
  static Unification fixed(double lambda);
  /// Adaptive Lambda: the lambda for which both have the same mean over the initial edges,
  /// mu_G / (mu_C + mu_G); 1/2 if both means are 0. If only one is, as that of colour in a cloud without any, its term
  /// tells nothing apart, and the other decides alone: by the formula all weights would be 0.
  static Unification adaptive(std::span<const double> color, std::span<const double> geometry,
                              const StopToken& stop = {});
  /// Equalization: half the empirical distribution function, F(v) = share of the initial edges <= v.
  static Unification equalization(std::span<const double> color, std::span<const double> geometry,
                                  const StopToken& stop = {});

  /// T_C(color) + T_G(geometry)
  double operator()(double color, double geometry) const;

  double lambda() const { return lambda_; }

 private:
  double lambda_ = 0.5;
  std::vector<double> color_, geometry_;  // ascending; empty unless Equalization
};

}  // namespace segserve
