// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <random>
#include <span>
#include <vector>

#include "client/bench_report/measured_run.hpp"

// Replicates of the figures of a load test, by the bootstrap. They show how far a figure could differ if the test were
// run again. Frames that are neighbors in time resemble each other, so that frames must not be drawn one by one.
namespace segserve::bench_report {

using Random = std::mt19937_64;
inline constexpr std::size_t kReplicates = 4000;

/// The number of independent frames that tell the share `q` below a quantile as well as the frames of this run do. It
/// is what their binomial variance would be, q (1 - q) / n, by that of the shares in the entries of the timeline, which
/// are taken to be an AR(1) process. Never more than there are frames.
double effective_frames(const MeasuredRun& run, double q);

/// Replicates of a quantile of the latency in ms. The quantile of a bootstrap sample of n frames is the order statistic
/// of a rank with the distribution Beta(n q, n (1 - q)), which is drawn directly; n are the effective frames, and the
/// value at the rank is that of the histogram, with its values spread evenly over a bucket.
std::vector<double> quantile_replicates(const MeasuredRun& run, double q, Random& random);

/// Replicates of a figure of the timeline, by the circular block bootstrap (Politis and Romano): blocks of entries that
/// follow each other are drawn with replacement, until there are as many as in the timeline. Blocks are the longer, the
/// more an entry resembles the one before (Carlstein's rule), and replicates stand so much farther off as Student's t
/// does for so many blocks. Empty if the timeline has fewer than four entries.
std::vector<double> timeline_replicates(const MeasuredRun& run,
                                        const std::function<double(std::span<const Interval>)>& figure, Random& random);

}  // namespace segserve::bench_report
