// SPDX-License-Identifier: Apache-2.0
#include "client/segctl/peer_method.hpp"

#include <utility>

#include "fmt/format.h"
#ifdef SEGSERVE_WITH_PCL
#include <dlfcn.h>

#include "client/segctl/lccp_module.hpp"
#include "core/base/status_macros.hpp"
#endif

namespace segserve::segctl {
namespace {

#ifdef SEGSERVE_WITH_PCL
/// The function of the module segctl_lccp.so, which the linker's run path of segctl leads to. The module stays loaded.
absl::StatusOr<decltype(&segctl_lccp_partition)> load_lccp() {
  void* const module = dlopen("segctl_lccp.so", RTLD_NOW | RTLD_LOCAL);
  void* const function = module == nullptr ? nullptr : dlsym(module, "segctl_lccp_partition");
  if (function == nullptr) return absl::UnavailableError(fmt::format("--peer lccp cannot be loaded: {}", dlerror()));
  return reinterpret_cast<decltype(&segctl_lccp_partition)>(function);
}

absl::StatusOr<eval::SegmentScene> lccp() {
  ASSIGN_OR_RETURN(const auto partition, load_lccp());
  return [partition](const CloudView& cloud) {
    absl::StatusOr<eval::Partition> result;
    partition(cloud, result);
    return result;
  };
}
#else
absl::StatusOr<eval::SegmentScene> lccp() {
  return absl::InvalidArgumentError(
      "--peer lccp: this segctl was built without PCL; build it with -DSEGSERVE_BUILD_PCL=ON, which needs libpcl-dev");
}
#endif

}  // namespace

absl::StatusOr<PeerMethod> peer_method(const std::string& name) {
  if (name != "lccp") return absl::InvalidArgumentError(fmt::format("--peer {}: must be lccp", name));
  auto segment = lccp();
  if (!segment.ok()) return segment.status();
  return PeerMethod{"pcl-lccp", *std::move(segment)};
}

}  // namespace segserve::segctl
