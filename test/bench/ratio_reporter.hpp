#pragma once

#include <benchmark/benchmark.h>

#include <algorithm>
#include <limits>
#include <map>
#include <string>
#include <vector>

namespace segserve::bench {

/// The usual table, then a line per frame that divides the time of a peer by ours, both taken in this
/// run. Benchmarks are named "WHAT/FRAME". The fastest of the repetitions counts: others only add what
/// else the machine was doing.
class RatioReporter : public benchmark::ConsoleReporter {
 public:
  RatioReporter(std::string ours, std::string peer)
      : ConsoleReporter(OO_None), ours_(std::move(ours)), peer_(std::move(peer)) {}

  void ReportRuns(const std::vector<Run>& runs) override;
  void Finalize() override;

 private:
  std::string ours_, peer_;
  std::map<std::string, std::map<std::string, double>> fastest_ms_;  // by frame, then by what
};

}  // namespace segserve::bench
