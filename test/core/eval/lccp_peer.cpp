// A peer, not a test: scores PCL's LCCP (or its plain supervoxels) on a folder of scenes with our scoring code, and
// writes what `segctl eval --json` writes, so that `segctl eval --compare` takes it. Settings:
// core/segserve/eval/README.md.
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>
#include <pcl/segmentation/lccp_segmentation.h>
#include <pcl/segmentation/supervoxel_clustering.h>

#include <chrono>
#include <cstdio>
#include <fstream>
#include <set>

#include "CLI/CLI.hpp"
#include "fmt/format.h"
#include "segserve/eval/evaluation.hpp"
#include "segserve/eval/report.hpp"
#include "segserve/segctl/degradation_flags.hpp"

namespace segserve {
namespace {

using Point = pcl::PointXYZRGBA;
using Points = pcl::PointCloud<Point>;
using Clustering = pcl::SupervoxelClustering<Point>;
using Supervoxels = std::map<std::uint32_t, pcl::Supervoxel<Point>::Ptr>;

struct Settings {
  float voxel_resolution = 0.0075F, seed_resolution = 0.03F;
  float color = 0, spatial = 1, normal = 4;
  float concavity_degrees = 10, smoothness = 0.1F;
  std::uint32_t k_factor = 0, min_segment_supervoxels = 3;
  bool only_supervoxels = false;
};

Points::Ptr to_pcl(const CloudView& cloud) {
  const Points::Ptr points(new Points(cloud.width, cloud.height));
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    Point& p = (*points)[i];
    p.x = cloud.x[i], p.y = cloud.y[i], p.z = cloud.z[i];
    p.rgba = 0xff000000U | (cloud.has_color() ? cloud.rgb[i] : 0U);
  }
  points->is_dense = false;
  return points;
}

Clustering clustering_of(const Points::Ptr& points, const Settings& s, ViewKind view) {
  Clustering clustering(s.voxel_resolution, s.seed_resolution);
  clustering.setUseSingleCameraTransform(view == ViewKind::kCamera);
  clustering.setInputCloud(points);
  clustering.setColorImportance(s.color);
  clustering.setSpatialImportance(s.spatial);
  clustering.setNormalImportance(s.normal);
  return clustering;
}

void merge(Clustering& clustering, const Supervoxels& supervoxels, const Settings& s,
           pcl::PointCloud<pcl::PointXYZL>& labelled) {
  std::multimap<std::uint32_t, std::uint32_t> adjacency;
  clustering.getSupervoxelAdjacency(adjacency);
  pcl::LCCPSegmentation<Point> lccp;
  lccp.setConcavityToleranceThreshold(s.concavity_degrees);
  lccp.setSanityCheck(true);
  lccp.setSmoothnessCheck(true, s.voxel_resolution, s.seed_resolution, s.smoothness);
  lccp.setKFactor(s.k_factor);
  lccp.setInputSupervoxels(supervoxels, adjacency);
  lccp.setMinSegmentSize(s.min_segment_supervoxels);
  lccp.segment();
  lccp.relabelCloud(labelled);
}

std::vector<std::uint32_t> labels_of(const pcl::PointCloud<pcl::PointXYZL>& cloud) {
  std::vector<std::uint32_t> labels;
  for (const pcl::PointXYZL& point : cloud) labels.push_back(point.label);
  return labels;
}

std::size_t distinct(const std::vector<std::uint32_t>& labels) {
  std::set<std::uint32_t> seen(labels.begin(), labels.end());
  seen.erase(0);
  return seen.size();
}

eval::Partition segment_by_pcl(const CloudView& cloud, const Settings& settings) {
  const Points::Ptr points = to_pcl(cloud);
  const auto start = std::chrono::steady_clock::now();
  Clustering clustering = clustering_of(points, settings, cloud.view.kind);
  Supervoxels supervoxels;
  clustering.extract(supervoxels);
  const pcl::PointCloud<pcl::PointXYZL>::Ptr labelled = clustering.getLabeledCloud();
  eval::Partition partition;
  partition.supervoxels = labels_of(*labelled);
  if (!settings.only_supervoxels) merge(clustering, supervoxels, settings, *labelled);
  partition.labels = labels_of(*labelled);
  partition.ms = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  partition.supervoxel_count = supervoxels.size();
  partition.segment_count = distinct(partition.labels);
  return partition;
}

void add_flags(CLI::App& app, Settings& s) {
  const auto setting = [&](const char* flag, auto& value, const char* help) {
    app.add_option(flag, value, help)->capture_default_str()->group("Settings");
  };
  setting("--voxel-resolution", s.voxel_resolution, "metres");
  setting("--seed-resolution", s.seed_resolution, "metres");
  setting("--color-weight", s.color, "of supervoxels");
  setting("--spatial-weight", s.spatial, "of supervoxels");
  setting("--normal-weight", s.normal, "of supervoxels");
  setting("--concavity", s.concavity_degrees, "tolerance, degrees");
  setting("--smoothness", s.smoothness, "threshold of the smoothness check");
  setting("--k-factor", s.k_factor, "extended convexity: neighbours in common");
  setting("--min-segment", s.min_segment_supervoxels, "supervoxels of a segment that is not absorbed");
  app.add_flag("--only-supervoxels", s.only_supervoxels, "plain VCCS, nothing merged")->group("Settings");
}

absl::Status run(const std::string& folder, const std::string& json_path, const eval::Degradation& degradation,
                 const Settings& settings) {
  if (absl::Status status = eval::check(degradation); !status.ok()) return status;
  const auto files = eval::scene_files(folder);
  if (!files.ok()) return files.status();
  eval::Report report;
  report.method = settings.only_supervoxels ? "pcl-vccs" : "pcl-lccp";
  report.folder = folder;
  report.degradation = degradation;
  auto rows = eval::evaluate(
      *files, degradation,
      [&](const CloudView& cloud) -> absl::StatusOr<eval::Partition> { return segment_by_pcl(cloud, settings); },
      [](std::size_t, std::size_t) {});
  if (!rows.ok()) return rows.status();
  report.per_scene = *std::move(rows);
  if (!json_path.empty()) {
    std::ofstream file(json_path, std::ios::binary);
    if (!(file << eval::to_json(report) << std::flush)) return absl::UnavailableError("cannot write " + json_path);
  }
  std::fputs(eval::to_text(report).c_str(), stdout);
  return absl::OkStatus();
}

}  // namespace
}  // namespace segserve

int main(int argc, char** argv) {
  CLI::App app("Scores PCL's LCCP with segserve's scoring code.", "lccp_peer");
  segserve::Settings settings;
  segserve::segctl::DegradationFlags degradation;
  std::string folder, json_path;
  app.add_option("--data", folder, "folder of scenes with ground truth")->required();
  app.add_option("--json", json_path, "write the result as one JSON object");
  degradation.add_to(app);
  segserve::add_flags(app, settings);
  CLI11_PARSE(app, argc, argv);
  const absl::Status status = segserve::run(folder, json_path, degradation.degradation(), settings);
  if (!status.ok()) std::fprintf(stderr, "lccp_peer: %s\n", std::string(status.message()).c_str());
  return status.ok() ? 0 : 1;
}
