// SPDX-License-Identifier: Apache-2.0
#include "core/lab/eval/comparison.hpp"

#include <algorithm>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <limits>
#include <numeric>
#include <string>
#include <string_view>

#include "core/base/status_macros.hpp"
#include "core/math/random.hpp"
#include "fmt/format.h"

namespace segserve::eval {
namespace {

constexpr std::size_t kResamples = 10'000;
constexpr std::size_t kTail = kResamples / 40;  // 2.5 % on each side

using Rows = std::vector<const SceneScores*>;

/// The scenes sorted by file name. `which` names the result in errors.
absl::StatusOr<Rows> sorted_by_file(std::span<const SceneScores> scenes, std::string_view which) {
  Rows rows;
  for (const SceneScores& scene : scenes) rows.push_back(&scene);
  const auto file = [](const SceneScores* row) { return std::string_view(row->file); };
  std::ranges::sort(rows, {}, file);
  const auto twice = std::ranges::adjacent_find(rows, {}, file);
  if (twice != rows.end()) {
    return absl::InvalidArgumentError(fmt::format("{} is in the {} result twice", (*twice)->file, which));
  }
  return rows;
}

absl::Status check_same_files(const Rows& a, const Rows& b) {
  const auto has = [](const Rows& rows, std::string_view file) {
    return std::ranges::any_of(rows, [&](const SceneScores* row) { return row->file == file; });
  };
  for (const SceneScores* row : a) {
    if (!has(b, row->file)) return absl::InvalidArgumentError(row->file + " is in the first result only");
  }
  for (const SceneScores* row : b) {
    if (!has(a, row->file)) return absl::InvalidArgumentError(row->file + " is in the second result only");
  }
  if (a.size() < 2) return absl::InvalidArgumentError(fmt::format("{} scene is too few to compare", a.size()));
  return absl::OkStatus();
}

double mean_of(std::span<const double> values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

/// Sets the 95 % interval of the mean difference.
void bootstrap(std::span<const double> differences, PairedDifference& result) {
  Random random(result.scenes);
  std::vector<double> means(kResamples);
  for (double& resampled : means) {
    double sum = 0;
    for (std::size_t i = 0; i < differences.size(); ++i) {
      sum += differences[random.below(static_cast<std::uint32_t>(differences.size()))];
    }
    resampled = sum / static_cast<double>(differences.size());
  }
  std::ranges::sort(means);
  result.low = means[kTail];
  result.high = means[kResamples - 1 - kTail];
}

/// P(T > t) with Student's distribution of the given degrees of freedom.
double upper_tail(double t, double degrees) {
  if (std::isinf(t)) return t > 0 ? 0 : 1;
  return boost::math::cdf(boost::math::complement(boost::math::students_t(degrees), t));
}

/// Sets the paired t-test.
void t_test(std::span<const double> differences, PairedDifference& result) {
  const double n = static_cast<double>(differences.size());
  double squares = 0;
  for (const double d : differences) squares += (d - result.difference) * (d - result.difference);
  const double error = std::sqrt(squares / (n - 1) / n);
  const bool constant = std::ranges::all_of(differences, [&](double d) { return d == differences.front(); });
  if (constant) {
    const double only = differences.front();
    result.t = only == 0 ? 0 : std::copysign(std::numeric_limits<double>::infinity(), only);
  } else {
    result.t = result.difference / error;
  }
  result.p_two_sided = std::min(1.0, 2 * upper_tail(std::abs(result.t), n - 1));
  const Better better = kMetrics[result.metric].better;
  if (better != Better::kNeither) result.p_better = upper_tail(better == Better::kHigher ? result.t : -result.t, n - 1);
}

/// Unset if fewer than two scenes have the metric in both results.
std::optional<PairedDifference> compare_by(std::size_t metric, const Rows& a, const Rows& b) {
  std::vector<double> of_a, of_b, differences;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const auto& x = a[i]->values[metric];
    const auto& y = b[i]->values[metric];
    if (!x || !y) continue;
    of_a.push_back(*x);
    of_b.push_back(*y);
    differences.push_back(*x - *y);
  }
  if (differences.size() < 2) return std::nullopt;
  PairedDifference result;
  result.metric = metric;
  result.scenes = differences.size();
  result.mean_a = mean_of(of_a);
  result.mean_b = mean_of(of_b);
  result.difference = mean_of(differences);
  bootstrap(differences, result);
  t_test(differences, result);
  return result;
}

}  // namespace

absl::StatusOr<std::vector<PairedDifference>> compare(std::span<const SceneScores> a, std::span<const SceneScores> b) {
  ASSIGN_OR_RETURN(const Rows rows_a, sorted_by_file(a, "first"));
  ASSIGN_OR_RETURN(const Rows rows_b, sorted_by_file(b, "second"));
  RETURN_IF_ERROR(check_same_files(rows_a, rows_b));
  std::vector<PairedDifference> results;
  for (std::size_t metric = 0; metric < kMetrics.size(); ++metric) {
    if (const auto result = compare_by(metric, rows_a, rows_b)) results.push_back(*result);
  }
  return results;
}

}  // namespace segserve::eval
