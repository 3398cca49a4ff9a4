// SPDX-License-Identifier: Apache-2.0
// A peer, not a test: scores PCL's LCCP (or its plain supervoxels) on a folder of scenes with our scoring code, and
// writes what `segctl eval --json` writes, so that `segctl eval --compare` takes it. Unlike
// `segctl eval --peer lccp`, its settings are flags. They stand in core/lab/eval/README.md.

#include <cstdio>
#include <fstream>

#include "CLI/CLI.hpp"
#include "client/segctl/degradation_flags.hpp"
#include "core/lab/eval/evaluation.hpp"
#include "core/lab/eval/report.hpp"
#include "core/pcl_adapter/peer/lccp_partition.hpp"

namespace segserve {
namespace {

using pcl_peer::PeerSettings;

void add_flags(CLI::App& app, PeerSettings& s) {
  const auto setting = [&](const char* flag, auto& value, const char* help) {
    app.add_option(flag, value, help)->capture_default_str()->group("Settings");
  };
  setting("--voxel-resolution", s.vccs.voxel_resolution, "meters");
  setting("--seed-resolution", s.vccs.seed_resolution, "meters");
  setting("--color-weight", s.vccs.color, "of supervoxels");
  setting("--spatial-weight", s.vccs.spatial, "of supervoxels");
  setting("--normal-weight", s.vccs.normal, "of supervoxels");
  setting("--concavity", s.lccp.concavity_degrees, "tolerance, degrees");
  setting("--smoothness", s.lccp.smoothness, "threshold of the smoothness check");
  setting("--k-factor", s.lccp.k_factor, "extended convexity: neighbors in common");
  setting("--min-segment", s.lccp.min_segment_supervoxels, "supervoxels of a segment that is not absorbed");
  app.add_flag("--only-supervoxels", s.only_supervoxels, "plain VCCS, nothing merged")->group("Settings");
}

absl::Status run(const std::string& folder, const std::string& json_path, const eval::Degradation& degradation,
                 const PeerSettings& settings) {
  if (absl::Status status = eval::check(degradation); !status.ok()) return status;
  const auto files = eval::scene_files(folder);
  if (!files.ok()) return files.status();
  eval::Report report;
  report.method = settings.only_supervoxels ? "pcl-vccs" : "pcl-lccp";
  report.folder = folder;
  report.degradation = degradation;
  eval::Evaluation evaluation = eval::evaluate(
      *files, degradation, [&](const CloudView& cloud) { return pcl_peer::partition(cloud, settings); },
      [](std::size_t, std::size_t) {});
  if (!evaluation.failures.empty()) return evaluation.failures.front().status;
  report.per_scene = std::move(evaluation.scores);
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
  segserve::pcl_peer::PeerSettings settings;
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
