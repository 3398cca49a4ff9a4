// SPDX-License-Identifier: Apache-2.0
// From points to labels and merge tree, stage by stage, on one core, with PCL as the peer in the same run.
// Run test/bench/ratios.py, which also computes the ratios, or segment_bench with the flags of Google Benchmark.
//
// A benchmark is named WHAT/FRAME, where WHAT is
//   border, lambda-convex   our whole segmentation,
//   pcl-vccs                PCL's SupervoxelClustering with the settings of lambda-convex, which makes only
//   supervoxels, pcl-lccp                PCL's SupervoxelClustering and LCCPSegmentation with LCCP's best settings,
//   which make labels.
#include <benchmark/benchmark.h>

#include <string>

#include "core/pcl_adapter/peer/pcl_peer.hpp"
#include "segserve/segment.hpp"
#include "test/bench/frames.hpp"

namespace segserve::bench {
namespace {

struct Stage {
  const char* name;
  double StageTimings::*ms;
};

constexpr Stage kStages[] = {{"voxels", &StageTimings::voxels},           {"normals", &StageTimings::normals},
                             {"supervoxels", &StageTimings::supervoxels}, {"graph", &StageTimings::graph},
                             {"merging", &StageTimings::merging},         {"labels", &StageTimings::labels}};

void time_ours(benchmark::State& state, const Frame& frame, Method method) {
  Options options;
  options.method = method;
  Segmenter segmenter;
  StageTimings sum;
  for (auto _ : state) {
    const absl::StatusOr<Segmentation> result = segmenter.segment(frame.cloud, options);
    if (!result.ok()) return state.SkipWithError(std::string(result.status().message()).c_str());
    for (const Stage& stage : kStages) sum.*stage.ms += result->timings.*stage.ms;
    state.counters["supervoxel_count"] = static_cast<double>(result->tree.leaf_count());
    state.counters["finite_points"] = static_cast<double>(result->finite_points);
    state.counters["voxel_count"] = static_cast<double>(result->voxels);
  }
  for (const Stage& stage : kStages) {
    state.counters[stage.name] = benchmark::Counter(sum.*stage.ms, benchmark::Counter::kAvgIterations);
  }
}

void time_pcl_vccs(benchmark::State& state, const Frame& frame) {
  const pcl_peer::PclCloud cloud(frame.cloud);
  const pcl_peer::VccsSettings settings = pcl_peer::same_as({.method = Method::kLambdaConvex});
  for (auto _ : state) {
    state.counters["supervoxel_count"] = static_cast<double>(pcl_peer::PclSupervoxels(cloud, settings).size());
  }
}

void time_pcl_lccp(benchmark::State& state, const Frame& frame) {
  const pcl_peer::PclCloud cloud(frame.cloud);
  for (auto _ : state) {
    const pcl_peer::PclSupervoxels supervoxels(cloud, {});
    benchmark::DoNotOptimize(supervoxels.merge({}));
    state.counters["supervoxel_count"] = static_cast<double>(supervoxels.size());
  }
}

void register_all() {
  for (const Frame& frame : frames()) {
    const auto add = [&](const std::string& what, auto function, auto... arguments) {
      benchmark::RegisterBenchmark((what + "/" + frame.name).c_str(), function, frame, arguments...)
          ->Unit(benchmark::kMillisecond)
          ->MinTime(0.2)
          ->Repetitions(5);
    };
    add("border", time_ours, Method::kBorder);
    add("pcl-lccp", time_pcl_lccp);
    add("lambda-convex", time_ours, Method::kLambdaConvex);
    add("pcl-vccs", time_pcl_vccs);
  }
}

}  // namespace
}  // namespace segserve::bench

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  segserve::bench::register_all();
  benchmark::RunSpecifiedBenchmarks();
}
