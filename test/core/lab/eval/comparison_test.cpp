// SPDX-License-Identifier: Apache-2.0
#include "core/lab/eval/comparison.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace segserve::eval {
namespace {

using Values = std::vector<double>;

std::vector<SceneScores> scenes(const Values& wov, const Values& fp = {}) {
  std::vector<SceneScores> rows;
  for (std::size_t i = 0; i < wov.size(); ++i) {
    SceneScores row{"scene" + std::to_string(i), {}};
    row.values[metric("one_to_one.wov")] = wov[i];
    if (!fp.empty()) row.values[metric("one_to_one.fp")] = fp[i];
    rows.push_back(row);
  }
  return rows;
}

const PairedDifference& of(const std::vector<PairedDifference>& all, std::size_t metric) {
  return *std::ranges::find(all, metric, &PairedDifference::metric);
}

// Student's sleep data (1908), as in the help of R's t.test: t = -4.0621, df = 9, p-value = 0.002833.
const Values kSleepA{0.7, -1.6, -0.2, -1.2, -0.1, 3.4, 3.7, 0.8, 0.0, 2.0};
const Values kSleepB{1.9, 0.8, 1.1, 0.1, -0.1, 4.4, 5.5, 1.6, 4.6, 3.4};

TEST(Compare, IsThePairedTTestOfStudentsSleepData) {
  const auto all = *compare(scenes(kSleepA), scenes(kSleepB));
  ASSERT_EQ(all.size(), 1U);  // no other metric is there
  const PairedDifference& d = all[0];
  EXPECT_EQ(d.scenes, 10U);
  EXPECT_DOUBLE_EQ(d.mean_a, 0.75);
  EXPECT_DOUBLE_EQ(d.mean_b, 2.33);
  EXPECT_NEAR(d.difference, -1.58, 1e-12);
  EXPECT_NEAR(d.t, -4.0621, 5e-5);
  EXPECT_NEAR(d.p_two_sided, 0.002833, 5e-7);
  EXPECT_NEAR(*d.p_better, 1 - 0.002833 / 2, 5e-7);
  // The bootstrap's interval: near the mean -+ 1.96 standard errors, somewhat narrower for ten scenes.
  EXPECT_NEAR(d.low, -1.58 - 1.96 * 0.389 * std::sqrt(0.9), 0.15);
  EXPECT_NEAR(d.high, -1.58 + 1.96 * 0.389 * std::sqrt(0.9), 0.15);
}

TEST(Compare, KnowsThatLessIsBetterOfErrors) {
  const auto all = *compare(scenes(kSleepA, kSleepA), scenes(kSleepB, kSleepB));
  EXPECT_GT(*of(all, metric("one_to_one.wov")).p_better, 0.99);
  EXPECT_LT(*of(all, metric("one_to_one.fp")).p_better, 0.01);
}

TEST(Compare, PairsByFileNotByOrder) {
  std::vector<SceneScores> b = scenes(kSleepB);
  std::ranges::reverse(b);
  const PairedDifference d = compare(scenes(kSleepA), b)->front();
  EXPECT_NEAR(d.t, -4.0621, 5e-5);
  EXPECT_EQ(d.low, compare(scenes(kSleepA), scenes(kSleepB))->front().low);  // the same on every run
}

TEST(Compare, DefinesTheTestOfConstantDifferences) {
  const PairedDifference none = compare(scenes(kSleepA), scenes(kSleepA))->front();
  EXPECT_EQ(none.t, 0);
  EXPECT_EQ(none.p_two_sided, 1);
  EXPECT_EQ(none.p_better, 0.5);
  const PairedDifference one = compare(scenes({2, 3}), scenes({1, 2}))->front();
  EXPECT_EQ(one.t, INFINITY);
  EXPECT_EQ(one.p_two_sided, 0);
  EXPECT_EQ(one.p_better, 0);
  EXPECT_EQ(one.low, 1);
  EXPECT_EQ(one.high, 1);
}

TEST(Compare, LeavesOutScenesThatLackTheMetric) {
  std::vector<SceneScores> a = scenes(kSleepA);
  a[3].values[metric("one_to_one.wov")].reset();
  EXPECT_EQ(compare(a, scenes(kSleepB))->front().scenes, 9U);
}

TEST(Compare, RefusesOtherScenes) {
  const auto message = [](const auto& a, const auto& b) { return std::string(compare(a, b).status().message()); };
  EXPECT_EQ(message(scenes({1, 2, 3}), scenes({1, 2})), "scene2 is in the first result only");
  EXPECT_EQ(message(scenes({1, 2}), scenes({1, 2, 3})), "scene2 is in the second result only");
  EXPECT_EQ(message(scenes({1}), scenes({1})), "1 scene is too few to compare");
  std::vector<SceneScores> twice = scenes({1, 2});
  twice[1].file = twice[0].file;
  EXPECT_EQ(message(scenes({1, 2}), twice), "scene0 is in the second result twice");
}

}  // namespace
}  // namespace segserve::eval
