// SPDX-License-Identifier: Apache-2.0
#include "client/segctl/peer_method.hpp"

#include <array>
#include <optional>
#include <string_view>
#include <utility>

#include "fmt/format.h"
#include "proto/text/number_list.hpp"
#ifdef SEGSERVE_WITH_PCL
#include <dlfcn.h>

#include "client/segctl/lccp_module.hpp"
#include "core/base/status_macros.hpp"
#endif

namespace segserve::segctl {
namespace {

/// The sizes of voxels and seeds in meters, if they were given.
using Resolutions = std::optional<std::array<float, 2>>;

#ifdef SEGSERVE_WITH_PCL
/// The function of the module segctl_lccp.so, which the linker's run path of segctl leads to. The module stays loaded.
absl::StatusOr<decltype(&segctl_lccp_partition)> load_lccp() {
  void* const module = dlopen("segctl_lccp.so", RTLD_NOW | RTLD_LOCAL);
  void* const function = module == nullptr ? nullptr : dlsym(module, "segctl_lccp_partition");
  if (function == nullptr) return absl::UnavailableError(fmt::format("--peer lccp cannot be loaded: {}", dlerror()));
  return reinterpret_cast<decltype(&segctl_lccp_partition)>(function);
}

absl::StatusOr<eval::SegmentScene> lccp(const Resolutions& resolutions) {
  ASSIGN_OR_RETURN(const auto partition, load_lccp());
  pcl_peer::PeerSettings settings;
  if (resolutions) {
    settings.vccs.voxel_resolution = (*resolutions)[0];
    settings.vccs.seed_resolution = (*resolutions)[1];
  }
  return [partition, settings](const CloudView& cloud) {
    absl::StatusOr<eval::Partition> result;
    partition(cloud, settings, result);
    return result;
  };
}
#else
absl::StatusOr<eval::SegmentScene> lccp(const Resolutions& /*resolutions*/) {
  return absl::InvalidArgumentError(
      "--peer lccp: this segctl was built without PCL; build it with -DSEGSERVE_BUILD_PCL=ON, which needs libpcl-dev");
}
#endif

}  // namespace

absl::StatusOr<PeerMethod> peer_method(const std::string& text) {
  constexpr std::string_view kWithResolutions = "lccp:";
  Resolutions resolutions;
  if (text.starts_with(kWithResolutions)) {
    resolutions = text::parse_numbers<float, 2>(std::string_view(text).substr(kWithResolutions.size()));
  }
  const bool in_range = resolutions && (*resolutions)[0] > 0 && (*resolutions)[0] <= (*resolutions)[1];
  if (text != "lccp" && !in_range) {
    return absl::InvalidArgumentError(
        fmt::format("--peer {}: must be lccp, or lccp:V,S with the sizes of voxels and seeds in meters", text));
  }
  auto segment = lccp(resolutions);
  if (!segment.ok()) return segment.status();
  return PeerMethod{"pcl-" + text, *std::move(segment)};
}

}  // namespace segserve::segctl
