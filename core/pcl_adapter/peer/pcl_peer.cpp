// SPDX-License-Identifier: Apache-2.0
#include "core/pcl_adapter/peer/pcl_peer.hpp"

#include <pcl/point_cloud.h>
#include <pcl/point_types.h>
#include <pcl/segmentation/lccp_segmentation.h>
#include <pcl/segmentation/supervoxel_clustering.h>

#include <map>

namespace segserve::pcl_peer {
namespace {

using Point = pcl::PointXYZRGBA;

std::vector<std::uint32_t> labels_of(const pcl::PointCloud<pcl::PointXYZL>& cloud) {
  std::vector<std::uint32_t> labels;
  labels.reserve(cloud.size());
  for (const pcl::PointXYZL& point : cloud) labels.push_back(point.label);
  return labels;
}

}  // namespace

VccsSettings same_as(const Options& options) {
  const SupervoxelOptions o = supervoxel_options(options);
  constexpr double kVoxel = 0.0075, kSeed = 0.03;  // where the cloud would decide
  return {static_cast<float>(o.voxel_resolution.value_or(kVoxel)),
          static_cast<float>(o.seed_resolution.value_or(kSeed)), static_cast<float>(o.color_weight),
          static_cast<float>(o.spatial_weight), static_cast<float>(o.normal_weight)};
}

struct PclCloud::Points {
  pcl::PointCloud<Point>::Ptr cloud;
  bool camera = false;
};

PclCloud::PclCloud(const CloudView& cloud) : points_(std::make_unique<Points>()) {
  points_->camera = cloud.view.kind == ViewKind::kCamera;
  points_->cloud.reset(new pcl::PointCloud<Point>(cloud.width, cloud.height));
  points_->cloud->is_dense = false;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    Point& p = (*points_->cloud)[i];
    p.x = cloud.x[i], p.y = cloud.y[i], p.z = cloud.z[i];
    p.rgba = 0xff000000U | (cloud.has_color() ? cloud.rgb[i] : 0U);
  }
}

PclCloud::~PclCloud() = default;
PclCloud::PclCloud(PclCloud&&) noexcept = default;
PclCloud& PclCloud::operator=(PclCloud&&) noexcept = default;

struct PclSupervoxels::State {
  VccsSettings settings;
  pcl::SupervoxelClustering<Point> clustering;
  std::map<std::uint32_t, pcl::Supervoxel<Point>::Ptr> supervoxels;
};

PclSupervoxels::PclSupervoxels(const PclCloud& cloud, const VccsSettings& settings)
    : state_(new State{settings, {settings.voxel_resolution, settings.seed_resolution}, {}}) {
  pcl::SupervoxelClustering<Point>& clustering = state_->clustering;
  clustering.setUseSingleCameraTransform(cloud.points_->camera);
  clustering.setInputCloud(cloud.points_->cloud);
  clustering.setColorImportance(settings.color);
  clustering.setSpatialImportance(settings.spatial);
  clustering.setNormalImportance(settings.normal);
  clustering.extract(state_->supervoxels);
}

PclSupervoxels::~PclSupervoxels() = default;

std::size_t PclSupervoxels::size() const { return state_->supervoxels.size(); }

std::vector<std::uint32_t> PclSupervoxels::labels() const { return labels_of(*state_->clustering.getLabeledCloud()); }

std::vector<std::uint32_t> PclSupervoxels::merge(const LccpSettings& settings) const {
  const VccsSettings& vccs = state_->settings;
  std::multimap<std::uint32_t, std::uint32_t> adjacency;
  state_->clustering.getSupervoxelAdjacency(adjacency);
  pcl::LCCPSegmentation<Point> lccp;
  lccp.setConcavityToleranceThreshold(settings.concavity_degrees);
  lccp.setSanityCheck(true);
  lccp.setSmoothnessCheck(true, vccs.voxel_resolution, vccs.seed_resolution, settings.smoothness);
  lccp.setKFactor(settings.k_factor);
  lccp.setInputSupervoxels(state_->supervoxels, adjacency);
  lccp.setMinSegmentSize(settings.min_segment_supervoxels);
  lccp.segment();
  const pcl::PointCloud<pcl::PointXYZL>::Ptr labeled = state_->clustering.getLabeledCloud();
  lccp.relabelCloud(*labeled);
  return labels_of(*labeled);
}

}  // namespace segserve::pcl_peer
