// SPDX-License-Identifier: Apache-2.0
#define SEGSERVE_SIMD_TARGET baseline
#include "core/math/elementary.hpp"

#include "core/simd/elementary_functions.hpp"

namespace segserve::math {

double ln(double x) { return baseline::ln(x); }
double exp(double x) { return baseline::exp(x); }
double pow(double x, double y) { return baseline::pow(x, y); }
double cbrt(double x) { return baseline::cbrt(x); }
double sin(double x) { return baseline::sin(x); }
double cos(double x) { return baseline::cos(x); }
double atan2(double y, double x) { return baseline::atan2(y, x); }

}  // namespace segserve::math
