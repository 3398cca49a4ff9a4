// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "segserve/cloud.hpp"

namespace segserve::bench {

struct Frame {
  std::string name;
  Cloud cloud;
};

/// The frames that are timed: a few OSD scenes if they are there (SEGSERVE_DATA_DIR/osd/learn), one of them also with
/// its holes filled (307,200 finite points); a synthetic tabletop as a Kinect sees it; and a synthetic tabletop with
/// 307,200 finite points, whose depths and colors have more noise.
const std::vector<Frame>& frames();

}  // namespace segserve::bench
