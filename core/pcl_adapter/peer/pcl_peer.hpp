// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "segserve/cloud.hpp"
#include "segserve/options.hpp"

// PCL's VCCS and LCCP as a peer of ours. PCL's headers stay in the source, because they take ten seconds to compile.
namespace segserve::pcl_peer {

/// Of pcl::SupervoxelClustering. The defaults are those that suit LCCP on OSD best (core/lab/eval/README.md).
struct VccsSettings {
  float voxel_resolution = 0.0075F, seed_resolution = 0.03F;  ///< meters
  float color = 0, spatial = 1, normal = 4;                   ///< weights
};

/// What our pipeline uses with these options.
VccsSettings same_as(const Options& options);

/// Of pcl::LCCPSegmentation, after its authors.
struct LccpSettings {
  float concavity_degrees = 10, smoothness = 0.1F;
  std::uint32_t k_factor = 0;                 ///< extended convexity: neighbors in common
  std::uint32_t min_segment_supervoxels = 3;  ///< of a segment that is not absorbed
};

/// A cloud as PCL keeps it.
class PclCloud {
 public:
  explicit PclCloud(const CloudView& cloud);
  ~PclCloud();
  PclCloud(PclCloud&&) noexcept;
  PclCloud& operator=(PclCloud&&) noexcept;

 private:
  friend class PclSupervoxels;
  struct Points;
  std::unique_ptr<Points> points_;
};

/// The supervoxels of a cloud by VCCS, which the constructor computes. The cloud must live as long.
class PclSupervoxels {
 public:
  PclSupervoxels(const PclCloud& cloud, const VccsSettings& settings);
  ~PclSupervoxels();

  std::size_t size() const;
  /// Of every input point; 0: PCL left it out.
  std::vector<std::uint32_t> labels() const;
  /// The segment of every input point by LCCP; 0: PCL left it out.
  std::vector<std::uint32_t> merge(const LccpSettings& settings) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace segserve::pcl_peer
