// SPDX-License-Identifier: Apache-2.0
// The code of docs/coming_from_pcl.md: it compiles, it does the same jobs, and the page has it as it stands here.
#include <gmock/gmock.h>
#include <pcl/ModelCoefficients.h>
#include <pcl/PointIndices.h>
#include <pcl/common/point_tests.h>
#include <pcl/filters/extract_indices.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>
#include <pcl/search/kdtree.h>
#include <pcl/segmentation/extract_clusters.h>
#include <pcl/segmentation/lccp_segmentation.h>
#include <pcl/segmentation/sac_segmentation.h>
#include <pcl/segmentation/supervoxel_clustering.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <fstream>
#include <iterator>
#include <map>
#include <memory>
#include <numeric>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/lab/synth/table_rig.hpp"
#include "segserve/cameras.hpp"
#include "segserve/client/client.hpp"
#include "segserve/pcl_adapter.hpp"
#include "segserve/pcl_client.hpp"
#include "server/server.hpp"

// clang-format off

namespace seg = segserve::pcl_adapter;
using Cloud = pcl::PointCloud<pcl::PointXYZRGBA>;

std::vector<std::uint32_t> lccp_with_pcl(const Cloud::ConstPtr& cloud) {
  pcl::SupervoxelClustering<pcl::PointXYZRGBA> supervoxels(0.0075F, 0.03F);
  supervoxels.setUseSingleCameraTransform(true);
  supervoxels.setInputCloud(cloud);
  supervoxels.setColorImportance(0.0F);
  supervoxels.setSpatialImportance(1.0F);
  supervoxels.setNormalImportance(4.0F);
  std::map<std::uint32_t, pcl::Supervoxel<pcl::PointXYZRGBA>::Ptr> clusters;
  supervoxels.extract(clusters);
  std::multimap<std::uint32_t, std::uint32_t> adjacency;
  supervoxels.getSupervoxelAdjacency(adjacency);

  pcl::LCCPSegmentation<pcl::PointXYZRGBA> lccp;
  lccp.setConcavityToleranceThreshold(10);
  lccp.setSanityCheck(true);
  lccp.setSmoothnessCheck(true, 0.0075F, 0.03F, 0.1F);
  lccp.setInputSupervoxels(clusters, adjacency);
  lccp.segment();
  const auto labeled = supervoxels.getLabeledCloud();
  lccp.relabelCloud(*labeled);
  std::vector<std::uint32_t> labels;
  for (const pcl::PointXYZL& point : *labeled) labels.push_back(point.label);
  return labels;
}

absl::StatusOr<std::vector<std::uint32_t>> lccp_with_segserve(const Cloud& cloud) {
  const auto result = seg::segment(cloud, segserve::View::camera());
  if (!result.ok()) return result.status();
  return result->labels;
}

std::size_t supervoxels_with_pcl(const Cloud::ConstPtr& cloud, std::map<std::uint32_t, pcl::PointNormal>& centers) {
  pcl::SupervoxelClustering<pcl::PointXYZRGBA> clustering(0.01F, 0.08F);
  clustering.setUseSingleCameraTransform(true);
  clustering.setInputCloud(cloud);
  clustering.setColorImportance(0.2F);
  clustering.setSpatialImportance(0.4F);
  clustering.setNormalImportance(1.0F);
  std::map<std::uint32_t, pcl::Supervoxel<pcl::PointXYZRGBA>::Ptr> clusters;
  clustering.extract(clusters);
  for (const auto& [label, supervoxel] : clusters) supervoxel->getCentroidPointNormal(centers[label]);
  return clusters.size();
}

absl::StatusOr<std::size_t> supervoxels_with_segserve(const Cloud& cloud, std::vector<pcl::PointNormal>& centers) {
  const segserve::Options options{.method = segserve::Method::kLambdaConvex,
                                  .voxel_resolution = 0.01,
                                  .seed_resolution = 0.08,
                                  .color_weight = 0.2,
                                  .spatial_weight = 0.4,
                                  .normal_weight = 1.0};
  const auto result = seg::segment(cloud, segserve::View::camera(), options);
  if (!result.ok()) return result.status();
  for (std::size_t s = 0; s < result->supervoxel_features.size(); ++s) {
    const Eigen::Vector3f center = result->supervoxel_features[s].centroid.cast<float>();
    const Eigen::Vector3f normal = result->supervoxel_normals[s].normalized().cast<float>();
    centers.emplace_back(center.x(), center.y(), center.z(), normal.x(), normal.y(), normal.z());
  }
  return centers.size();
}

std::vector<pcl::PointIndices> clusters_with_pcl(const Cloud::ConstPtr& cloud) {
  pcl::SACSegmentation<pcl::PointXYZRGBA> plane;
  plane.setModelType(pcl::SACMODEL_PLANE);
  plane.setMethodType(pcl::SAC_RANSAC);
  plane.setDistanceThreshold(0.01);
  plane.setMaxIterations(1000);
  plane.setInputCloud(cloud);
  pcl::PointIndices::Ptr table(new pcl::PointIndices);
  pcl::ModelCoefficients coefficients;
  plane.segment(*table, coefficients);

  pcl::ExtractIndices<pcl::PointXYZRGBA> rest;
  rest.setInputCloud(cloud);
  rest.setIndices(table);
  rest.setNegative(true);
  pcl::IndicesPtr objects(new pcl::Indices);
  rest.filter(*objects);
  std::erase_if(*objects, [&](pcl::index_t i) { return !pcl::isFinite((*cloud)[static_cast<std::size_t>(i)]); });

  pcl::EuclideanClusterExtraction<pcl::PointXYZRGBA> extraction;
  extraction.setSearchMethod(pcl::search::KdTree<pcl::PointXYZRGBA>::Ptr(new pcl::search::KdTree<pcl::PointXYZRGBA>));
  extraction.setClusterTolerance(0.02);
  extraction.setMinClusterSize(100);
  extraction.setInputCloud(cloud);
  extraction.setIndices(objects);
  std::vector<pcl::PointIndices> clusters;
  extraction.extract(clusters);
  return clusters;
}

absl::StatusOr<std::vector<pcl::PointIndices>> clusters_with_segserve(const Cloud& cloud) {
  const auto result = seg::segment(cloud, segserve::View::camera(), {.support_plane_distance = 0.01});
  if (!result.ok()) return result.status();
  return seg::cluster_indices(result->labels, 100);
}

absl::StatusOr<std::vector<pcl::PointIndices>> components_with_segserve(const Cloud& cloud) {
  const auto result = seg::segment(cloud, segserve::View::camera(), {.threshold = 1, .support_plane_distance = 0.01});
  if (!result.ok()) return result.status();
  return seg::cluster_indices(result->labels, 100);
}

absl::StatusOr<std::vector<std::uint32_t>> near_points(const Cloud& cloud) {
  pcl::Indices near;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (cloud[i].z < 1.0F) near.push_back(static_cast<pcl::index_t>(i));
  }
  const auto result = seg::segment(cloud, near, segserve::View::camera());
  if (!result.ok()) return result.status();
  return result->labels;
}

absl::StatusOr<std::vector<std::uint32_t>> through_a_server(const segserve::client::Client& client,
                                                            const Cloud& cloud) {
  const auto result = seg::segment(client, cloud, segserve::View::camera());
  if (!result.ok()) return result.status();
  return result->segmentation.labels;
}

absl::StatusOr<std::vector<std::uint32_t>> two_sensors(const Cloud& left, const Cloud& right) {
  const segserve::Cloud seen[] = {seg::from_pcl(left, segserve::View::camera()),
                                  seg::from_pcl(right, segserve::View::camera())};
  const segserve::CameraCloud cameras[] = {{seen[0], seg::sensor_pose(left)}, {seen[1], seg::sensor_pose(right)}};
  const auto merged = segserve::merge_cameras(cameras);
  if (!merged.ok()) return merged.status();
  const auto result = segserve::segment(*merged, {});
  if (!result.ok()) return result.status();
  return result->labels;
}
// clang-format on

namespace {

using testing::HasSubstr;

Cloud::Ptr to_pcl(const segserve::Cloud& cloud) {
  Cloud::Ptr result(new Cloud(cloud.width, cloud.height));
  result->is_dense = false;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    pcl::PointXYZRGBA& point = (*result)[i];
    point.x = cloud.x[i], point.y = cloud.y[i], point.z = cloud.z[i];
    point.rgba = 0xff000000U | cloud.rgb[i];
  }
  return result;
}

/// A table that one camera, or two opposite ones, see.
std::vector<segserve::synth::RigView> table(std::uint32_t cameras) {
  auto views = segserve::synth::make_tabletop_rig(
      {.seed = 3, .width = 320, .height = 240, .objects = 5, .stacked = 0, .clutter = 0, .compact = true}, cameras);
  EXPECT_TRUE(views.ok()) << views.status();
  return *std::move(views);
}

std::size_t segments_of(const std::vector<std::uint32_t>& labels) {
  std::set<std::uint32_t> segments(labels.begin(), labels.end());
  segments.erase(0);
  return segments.size();
}

/// How many of the five objects have a segment that holds most of their points, and mostly theirs.
std::size_t found_objects(const std::vector<std::uint32_t>& truth, const std::vector<std::uint32_t>& labels) {
  std::map<std::uint32_t, std::map<std::uint32_t, std::size_t>> shared;
  std::map<std::uint32_t, std::size_t> object_points, segment_points;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    if (labels[i] == 0) continue;
    ++segment_points[labels[i]];
    if (truth[i] < 20) continue;
    ++object_points[truth[i]];
    ++shared[truth[i]][labels[i]];
  }
  std::size_t found = 0;
  for (const auto& [object, segments] : shared) {
    for (const auto& [segment, points] : segments) {
      found += 10 * points > 7 * object_points[object] && 10 * points > 7 * segment_points[segment] ? 1 : 0;
    }
  }
  return found;
}

std::vector<std::uint32_t> labels_of(const std::vector<pcl::PointIndices>& clusters, std::size_t points) {
  std::vector<std::uint32_t> labels(points);
  for (std::size_t c = 0; c < clusters.size(); ++c) {
    for (const pcl::index_t i : clusters[c].indices) {
      labels[static_cast<std::size_t>(i)] = static_cast<std::uint32_t>(c + 1);
    }
  }
  return labels;
}

class ComingFromPcl : public testing::Test {
 protected:
  const std::vector<segserve::synth::RigView> views_ = table(1);
  const Cloud::Ptr cloud_ = to_pcl(views_[0].scene.cloud);
  const std::vector<std::uint32_t>& truth_ = views_[0].scene.label;
};

TEST_F(ComingFromPcl, LccpAndSegserveFindTheObjects) {
  EXPECT_GE(found_objects(truth_, lccp_with_pcl(cloud_)), 3U);
  const auto labels = lccp_with_segserve(*cloud_);
  ASSERT_TRUE(labels.ok()) << labels.status();
  EXPECT_EQ(found_objects(truth_, *labels), 5U);
}

TEST_F(ComingFromPcl, SupervoxelsAreAsMany) {
  std::map<std::uint32_t, pcl::PointNormal> with_pcl;
  std::vector<pcl::PointNormal> with_segserve;
  const std::size_t expected = supervoxels_with_pcl(cloud_, with_pcl);
  const auto count = supervoxels_with_segserve(*cloud_, with_segserve);
  ASSERT_TRUE(count.ok()) << count.status();
  EXPECT_GT(expected, 20U);
  EXPECT_NEAR(static_cast<double>(*count), static_cast<double>(expected), 0.5 * static_cast<double>(expected));
  for (const pcl::PointNormal& center : with_segserve) EXPECT_GT(center.z, 0.3F);
}

TEST_F(ComingFromPcl, ClustersAreTheObjects) {
  const std::vector<pcl::PointIndices> with_pcl = clusters_with_pcl(cloud_);
  EXPECT_GE(found_objects(truth_, labels_of(with_pcl, cloud_->size())), 4U);
  for (const auto& clusters : {clusters_with_segserve(*cloud_), components_with_segserve(*cloud_)}) {
    ASSERT_TRUE(clusters.ok()) << clusters.status();
    EXPECT_GE(found_objects(truth_, labels_of(*clusters, cloud_->size())), 4U);
    EXPECT_GE(clusters->front().indices.size(), clusters->back().indices.size());
  }
}

TEST_F(ComingFromPcl, OnlyTheNearPointsAreSegmented) {
  const auto labels = near_points(*cloud_);
  ASSERT_TRUE(labels.ok()) << labels.status();
  ASSERT_EQ(labels->size(), cloud_->size());
  EXPECT_GT(segments_of(*labels), 0U);
  for (std::size_t i = 0; i < cloud_->size(); ++i) {
    ASSERT_TRUE((*cloud_)[i].z < 1.0F || (*labels)[i] == 0);
  }
}

TEST_F(ComingFromPcl, AServerGivesTheSame) {
  segserve::server::ServerOptions options;
  options.listen = "127.0.0.1:0";
  const auto server = segserve::server::Server::start(options, segserve::server::core_backend_factory());
  ASSERT_TRUE(server.ok()) << server.status();
  const auto client = segserve::client::Client::connect({.address = (*server)->address()});
  ASSERT_TRUE(client.ok()) << client.status();
  const auto there = through_a_server(*client, *cloud_);
  const auto here = lccp_with_segserve(*cloud_);
  ASSERT_TRUE(there.ok() && here.ok()) << there.status();
  EXPECT_EQ(*there, *here);

  const pcl::Indices some{5, 6, 7};
  const auto remote = seg::segment(*client, *cloud_, some, segserve::View::camera());
  ASSERT_TRUE(remote.ok()) << remote.status();
  EXPECT_EQ(remote->segmentation.labels, seg::segment(*cloud_, some, segserve::View::camera())->labels);
  const auto wrong = seg::segment(*client, *cloud_, pcl::Indices{-1}, segserve::View::camera());
  EXPECT_EQ(wrong.status().code(), absl::StatusCode::kInvalidArgument);
}

TEST_F(ComingFromPcl, TwoSensorsSeeTheSameObjects) {
  const auto views = table(2);
  std::vector<Cloud::Ptr> clouds;
  std::vector<std::uint32_t> truth;
  for (const segserve::synth::RigView& view : views) {
    clouds.push_back(to_pcl(view.scene.cloud));
    clouds.back()->sensor_origin_.head<3>() = view.pose.translation.cast<float>();
    clouds.back()->sensor_orientation_ = Eigen::Quaternionf(view.pose.rotation.cast<float>());
    truth.insert(truth.end(), view.scene.label.begin(), view.scene.label.end());
  }
  const auto labels = two_sensors(*clouds[0], *clouds[1]);
  ASSERT_TRUE(labels.ok()) << labels.status();
  EXPECT_GE(found_objects(truth, *labels), 4U);
}

TEST(ComingFromPclPage, HasTheCodeOfThisFile) {
  const auto content = [](const char* path) {
    std::ifstream file(path);
    return std::string{std::istreambuf_iterator<char>(file), {}};
  };
  const std::string page = content(SEGSERVE_PCL_PAGE), source = content(__FILE__);
  const std::string begin = "```cpp\n";
  std::size_t blocks = 0;
  for (std::size_t at = page.find(begin); at != std::string::npos; at = page.find(begin, at)) {
    at += begin.size();
    const std::string block = page.substr(at, page.find("```", at) - at);
    EXPECT_THAT(source, HasSubstr(block));
    ++blocks;
  }
  EXPECT_GE(blocks, 10U);
}

}  // namespace
