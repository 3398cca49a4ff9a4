#pragma once

#include <string>
#include <vector>

#include "segserve/cloud/cloud.hpp"

namespace segserve::bench {

struct Frame {
  std::string name;
  Cloud cloud;
};

/// The frames that are timed: a few OSD scenes if they are at hand (SEGSERVE_DATA_DIR/osd/learn), a synthetic
/// tabletop as a Kinect sees it, and a synthetic frame of 307,200 finite points.
const std::vector<Frame>& frames();

}  // namespace segserve::bench
