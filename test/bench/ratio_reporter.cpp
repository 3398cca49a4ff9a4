#include "test/bench/ratio_reporter.hpp"

#include <fmt/format.h>

namespace segserve::bench {

void RatioReporter::ReportRuns(const std::vector<Run>& runs) {
  ConsoleReporter::ReportRuns(runs);
  for (const Run& run : runs) {
    if (run.run_type != Run::RT_Iteration || run.error_occurred) continue;
    const std::string& name = run.run_name.function_name;
    const std::size_t slash = name.find('/');
    const double ms = run.GetAdjustedRealTime();
    double& fastest = fastest_ms_[name.substr(slash + 1)].try_emplace(name.substr(0, slash), ms).first->second;
    fastest = std::min(fastest, ms);
  }
}

void RatioReporter::Finalize() {
  GetOutputStream() << '\n';
  for (const auto& [frame, times] : fastest_ms_) {
    const auto ours = times.find(ours_), peer = times.find(peer_);
    if (ours == times.end() || peer == times.end()) continue;
    GetOutputStream() << fmt::format("{:<16} {} {:6.1f} ms, {} {:6.1f} ms, ratio {:.1f}\n", frame, ours_, ours->second,
                                     peer_, peer->second, peer->second / ours->second);
  }
}

}  // namespace segserve::bench
