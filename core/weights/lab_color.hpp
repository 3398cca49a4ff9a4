// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace segserve {

/// A color in CIE 1976 L*a*b* with the reference white D65: L in [0, 100].
struct Lab {
  double l = 0, a = 0, b = 0;
};

}  // namespace segserve
