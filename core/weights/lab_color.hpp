#pragma once

namespace segserve {

/// CIE 1976 L*a*b*, reference white D65: L in [0, 100].
struct Lab {
  double l = 0, a = 0, b = 0;
};

}  // namespace segserve
