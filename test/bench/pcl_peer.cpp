#include "test/bench/pcl_peer.hpp"

#include <pcl/point_cloud.h>
#include <pcl/point_types.h>
#include <pcl/segmentation/supervoxel_clustering.h>

namespace segserve::bench {

using Point = pcl::PointXYZRGBA;

struct PclVccs::Input {
  pcl::PointCloud<Point>::Ptr points;
  Options options;
  bool camera;
};

PclVccs::PclVccs(const CloudView& cloud, const Options& options)
    : input_(new Input{pcl::PointCloud<Point>::Ptr(new pcl::PointCloud<Point>(cloud.width, cloud.height)), options,
                       cloud.view.kind == ViewKind::kCamera}) {
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    Point& p = (*input_->points)[i];
    p.x = cloud.x[i], p.y = cloud.y[i], p.z = cloud.z[i];
    p.rgba = cloud.rgb[i] | 0xff000000U;
  }
  input_->points->is_dense = false;
}

PclVccs::~PclVccs() = default;

std::size_t PclVccs::run() const {
  const SupervoxelOptions options = supervoxel_options(input_->options);
  pcl::SupervoxelClustering<Point> clustering(static_cast<float>(options.voxel_resolution),
                                              static_cast<float>(options.seed_resolution));
  clustering.setUseSingleCameraTransform(input_->camera);
  clustering.setInputCloud(input_->points);
  clustering.setColorImportance(static_cast<float>(options.color_weight));
  clustering.setSpatialImportance(static_cast<float>(options.spatial_weight));
  clustering.setNormalImportance(static_cast<float>(options.normal_weight));
  std::map<std::uint32_t, pcl::Supervoxel<Point>::Ptr> clusters;
  clustering.extract(clusters);
  return clusters.size();
}

}  // namespace segserve::bench
