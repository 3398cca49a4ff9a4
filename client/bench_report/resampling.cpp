// SPDX-License-Identifier: Apache-2.0
#include "client/bench_report/resampling.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

namespace segserve::bench_report {
namespace {

constexpr std::size_t kLeastEntries = 4;  ///< of a timeline, to tell how much its entries differ

/// How much each of m values that follow each other in time resembles the one before: the coefficient of an AR(1)
/// process, 0 to 0.9. Its estimate is too low by (1 + 3 rho) / m (Kendall).
double persistence(std::span<const double> values) {
  const auto m = static_cast<double>(values.size());
  double mean = 0;
  for (const double value : values) mean += value / m;
  double variance = 0, covariance = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    variance += (values[i] - mean) * (values[i] - mean);
    if (i > 0) covariance += (values[i] - mean) * (values[i - 1] - mean);
  }
  if (variance <= 0) return 0;
  const double rho = covariance / variance;
  return std::clamp(rho + (1 + 3 * rho) / m, 0.0, 0.9);
}

/// The length of blocks that has the least error for the variance of the mean of an AR(1) process (Carlstein).
std::size_t block_length(std::span<const double> values) {
  const double rho = persistence(values);
  const double length =
      std::pow(std::sqrt(6.0) * rho / (1 - rho * rho), 2.0 / 3) * std::cbrt(static_cast<double>(values.size()));
  return std::clamp<std::size_t>(static_cast<std::size_t>(std::lround(length)), 1, values.size() / 3);
}

/// The factor by which an interval from so many independent values is wider than one from the normal distribution,
/// because the values must also tell their variance: the standard deviation of Student's t.
double student_factor(double values) { return std::sqrt(std::max(values - 1, 2.0) / std::max(values - 3, 1.0)); }

/// The share of the frames of an entry, failed ones included, whose latency is at most `ms`: by a line between its
/// percentiles, which are those of all its frames.
double share_below(const Interval& entry, double lowest_ms, double ms) {
  const double frames = entry.results + entry.failed;
  if (frames == 0) return 0;
  std::pair<double, double> before{lowest_ms, 0};
  const std::array<std::pair<std::optional<double>, double>, 4> known{
      {{entry.p50, 0.5}, {entry.p90, 0.9}, {entry.p99, 0.99}, {entry.max, entry.results / frames}}};
  for (const auto& [value, share] : known) {
    if (!value || share < before.second) continue;
    if (ms < *value) {
      const double width = *value - before.first;
      const double way = width > 0 ? std::max(0.0, ms - before.first) / width : 0;
      return before.second + (share - before.second) * way;
    }
    before = {*value, share};
  }
  return entry.results / frames;
}

/// The variance of the mean of m values that follow each other in time, if they are an AR(1) process: m of them tell as
/// much as m (1 - rho) / (1 + rho) independent ones.
double variance_of_mean(std::span<const double> values) {
  const auto m = static_cast<double>(values.size());
  double mean = 0, squares = 0;
  for (const double value : values) mean += value / m;
  for (const double value : values) squares += (value - mean) * (value - mean);
  const double rho = persistence(values);
  const double independent = m * (1 - rho) / (1 + rho);
  const double factor = student_factor(independent);
  return factor * factor * squares / std::max(m - (1 + rho) / (1 - rho), 1.0) / independent;
}

double beta(double a, double b, Random& random) {
  const double x = std::gamma_distribution<double>(a)(random), y = std::gamma_distribution<double>(b)(random);
  return x + y > 0 ? x / (x + y) : 0.5;
}

}  // namespace

double effective_frames(const MeasuredRun& run, double q) {
  const double all = run.frames();
  const double at = run.quantile(q);
  if (run.timeline.size() < kLeastEntries || !std::isfinite(at)) return all;
  double frames = 0;
  for (const Interval& entry : run.timeline) frames += entry.results + entry.failed;
  if (frames == 0) return all;
  const double lowest = run.latency.empty() ? 0 : run.latency.front().ms;
  const auto m = static_cast<double>(run.timeline.size());
  const auto below_of = [&](const Interval& entry) {
    return (entry.results + entry.failed) * share_below(entry, lowest, at);
  };
  double below = 0;
  for (const Interval& entry : run.timeline) below += below_of(entry);
  // The share in each entry, weighted by how many of the frames it has, as its difference to the share of all.
  std::vector<double> differences;
  differences.reserve(run.timeline.size());
  for (const Interval& entry : run.timeline) {
    differences.push_back((below_of(entry) - (entry.results + entry.failed) * below / frames) * m / frames);
  }
  const double variance = variance_of_mean(differences);
  return variance * all <= q * (1 - q) ? all : std::max(1.0, q * (1 - q) / variance);
}

std::vector<double> quantile_replicates(const MeasuredRun& run, double q, Random& random) {
  const double all = run.frames();
  if (all == 0) return {};
  const double n = effective_frames(run, q);
  std::vector<double> below;  // Frames in the buckets up to each, itself included.
  below.reserve(run.latency.size());
  double sum = 0;
  for (const Bucket& bucket : run.latency) below.push_back(sum += bucket.count);
  std::vector<double> replicates;
  for (std::size_t i = 0; i < kReplicates; ++i) {
    const double rank = all * beta(n * q, n * (1 - q), random);
    const auto at = static_cast<std::size_t>(std::ranges::lower_bound(below, rank) - below.begin());
    if (at == below.size()) {
      replicates.push_back(std::numeric_limits<double>::infinity());
      continue;
    }
    const Bucket& bucket = run.latency[at];
    const double least = at == 0 ? bucket.ms : std::max(run.latency[at - 1].ms, bucket.ms * 0.999);
    const double rest = bucket.count > 0 ? (below[at] - rank) / bucket.count : 0;
    replicates.push_back(bucket.ms - rest * (bucket.ms - least));
  }
  return replicates;
}

std::vector<double> timeline_replicates(const MeasuredRun& run,
                                        const std::function<double(std::span<const Interval>)>& figure,
                                        Random& random) {
  const std::size_t m = run.timeline.size();
  if (m < kLeastEntries) return {};
  std::vector<double> single;
  single.reserve(m);
  for (const Interval& entry : run.timeline) single.push_back(figure({&entry, 1}));
  const std::size_t length = block_length(single);
  const double own = figure(run.timeline);
  const double factor = student_factor(static_cast<double>(m) / static_cast<double>(length));
  std::uniform_int_distribution<std::size_t> first(0, m - 1);
  std::vector<double> replicates;
  std::vector<Interval> drawn;
  for (std::size_t i = 0; i < kReplicates; ++i) {
    drawn.clear();
    while (drawn.size() < m) {
      const std::size_t begin = first(random);
      for (std::size_t k = 0; k < length && drawn.size() < m; ++k) drawn.push_back(run.timeline[(begin + k) % m]);
    }
    replicates.push_back(own + factor * (figure(drawn) - own));
  }
  return replicates;
}

}  // namespace segserve::bench_report
