// Time from points to labels and merge tree, on one core, against PCL's VCCS, which only gets as far as
// the supervoxels. Run: segment_bench [--benchmark_filter=...] (all flags of Google Benchmark).
#include <benchmark/benchmark.h>

#include "segserve/pipeline/segment.hpp"
#include "test/bench/frames.hpp"
#include "test/bench/pcl_peer.hpp"
#include "test/bench/ratio_reporter.hpp"

namespace segserve::bench {
namespace {

void time_segment(benchmark::State& state, const Frame& frame, const Options& options) {
  Segmenter segmenter;
  StageTimings sum;
  for (auto _ : state) {
    const absl::StatusOr<Segmentation> result = segmenter.segment(frame.cloud, options);
    if (!result.ok()) return state.SkipWithError(std::string(result.status().message()).c_str());
    sum.voxels += result->timings.voxels;
    sum.normals += result->timings.normals;
    sum.supervoxels += result->timings.supervoxels;
    sum.graph += result->timings.graph;
    sum.merging += result->timings.merging;
    sum.labels += result->timings.labels;
    state.counters["m"] = static_cast<double>(result->tree.leaf_count());
    state.counters["finite"] = static_cast<double>(result->finite_points);
  }
  const auto mean = [](double ms) { return benchmark::Counter(ms, benchmark::Counter::kAvgIterations); };
  state.counters["1_voxels"] = mean(sum.voxels);
  state.counters["2_normals"] = mean(sum.normals);
  state.counters["3_supervoxels"] = mean(sum.supervoxels);
  state.counters["4_graph"] = mean(sum.graph);
  state.counters["5_merging"] = mean(sum.merging);
  state.counters["6_labels"] = mean(sum.labels);
}

void time_pcl(benchmark::State& state, const Frame& frame, const Options& options) {
  const PclVccs vccs(frame.cloud, options);
  for (auto _ : state) state.counters["m"] = static_cast<double>(vccs.run());
}

void register_all() {
  Options options;
  options.method = Method::kLambdaConvex;
  const auto add = [](const std::string& name, auto function, const Frame& frame, const Options& o) {
    benchmark::RegisterBenchmark(name.c_str(), function, frame, o)
        ->Unit(benchmark::kMillisecond)
        ->MinTime(0.2)
        ->Repetitions(5);
  };
  for (const Frame& frame : frames()) {
    add("lambda-convex/" + frame.name, time_segment, frame, options);
    add("pcl-vccs/" + frame.name, time_pcl, frame, options);
  }
}

}  // namespace
}  // namespace segserve::bench

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  segserve::bench::register_all();
  segserve::bench::RatioReporter reporter("lambda-convex", "pcl-vccs");
  benchmark::RunSpecifiedBenchmarks(&reporter);
}
