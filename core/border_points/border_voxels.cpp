// SPDX-License-Identifier: Apache-2.0
#include "core/border_points/border_voxels.hpp"

#include <algorithm>

#include "core/base/stop_check.hpp"

namespace segserve {
namespace {

/// A voxel at a border and a supervoxel on the other side.
struct Opposite {
  std::uint32_t voxel, supervoxel;
  auto operator<=>(const Opposite&) const = default;
};

std::vector<Opposite> find_opposites(const Supervoxels& supervoxels, const RegionGraph& graph,
                                     const std::vector<BorderEvidence>& evidence, StopCheck& check) {
  std::vector<std::uint8_t> separates(graph.edges.size());
  check.for_each(0, separates.size(), [&](std::size_t e) {
    separates[e] = static_cast<std::uint8_t>(evidence[e].sum >= BorderConstants{}.bias * evidence[e].contacts);
  });
  std::vector<Opposite> found;
  check.for_each(0, graph.contacts.size(), [&](std::size_t c) {
    if (separates[graph.edge_of_contact[c]] == 0) return;
    const auto [v, u] = graph.contacts[c];
    found.push_back({v, supervoxels.supervoxel_of_voxel[u]});
    found.push_back({u, supervoxels.supervoxel_of_voxel[v]});
  });
  return found;
}

}  // namespace

absl::Status find_border_voxels(const FrameContext& frame, const Supervoxels& supervoxels, const RegionGraph& graph,
                                const std::vector<BorderEvidence>& evidence, BorderVoxels& border) {
  StopCheck check(frame.stop);
  std::vector<Opposite> found = find_opposites(supervoxels, graph, evidence, check);
  std::sort(found.begin(), found.end());
  found.erase(std::unique(found.begin(), found.end()), found.end());
  check.after(found.size());
  border.opposite.resize(found.size());
  border.begin.resize(supervoxels.supervoxel_of_voxel.size() + 1);
  std::size_t next = 0;
  check.for_each(0, border.begin.size(), [&](std::size_t v) {
    border.begin[v] = static_cast<std::uint32_t>(next);
    for (; next < found.size() && found[next].voxel == v; ++next) border.opposite[next] = found[next].supervoxel;
  });
  return check.status();
}

}  // namespace segserve
