// SPDX-License-Identifier: Apache-2.0
#include "core/lab/eval/overlap_scores.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/lab/eval/instance_scores.hpp"
#include "test/core/lab/eval/random_labels.hpp"

namespace segserve::eval {
namespace {

OverlapScores scores_of(const Labels& truth, const Labels& labels) { return *overlap_scores(*tabulate(truth, labels)); }

TEST(OverlapScores, CountTheCommonPointsOfMatchedPairs) {
  //  table 1: 4 points, object 10: 4 points, object 11: 2 points
  const Labels truth{1, 1, 1, 1, 10, 10, 10, 10, 11, 11};
  const Labels labels{5, 5, 5, 6, 6, 6, 6, 7, 8, 8};
  // 10 and 6 have F = 2 * 3 / (4 + 4) = 0.75, 11 and 8 have F = 1; 7 is a false detection of one point.
  const OverlapScores s = scores_of(truth, labels);
  EXPECT_DOUBLE_EQ(*s.precision, 5.0 / 7);
  EXPECT_DOUBLE_EQ(s.recall, 5.0 / 6);
  EXPECT_DOUBLE_EQ(s.f, 2 * (5.0 / 7) * (5.0 / 6) / (5.0 / 7 + 5.0 / 6));
  EXPECT_DOUBLE_EQ(s.objects_f75, 1);
}

TEST(OverlapScores, AssignSegmentsSoThatTheSumOfFIsLargest) {
  // Segment 5 holds all of object 10 (3 points) and 3 of the 4 points of object 11, segment 6 the fourth one.
  // F: (10, 5) 6/9, (11, 5) 6/10, (11, 6) 2/5. The best sum is (10, 5) with (11, 6).
  const OverlapScores s = scores_of({10, 10, 10, 11, 11, 11, 11}, {5, 5, 5, 5, 5, 5, 6});
  EXPECT_DOUBLE_EQ(*s.precision, 4.0 / 7);
  EXPECT_DOUBLE_EQ(s.recall, 4.0 / 7);
  EXPECT_EQ(s.objects_f75, 0);
}

TEST(OverlapScores, HaveNoPrecisionWithoutADetection) {
  const OverlapScores s = scores_of({1, 1, 1, 10}, {2, 2, 2, 2});
  EXPECT_EQ(s.precision, std::nullopt);
  EXPECT_EQ(s.recall, 0);
  EXPECT_EQ(s.f, 0);
  EXPECT_EQ(overlap_scores(*tabulate(Labels{1, 9}, Labels{1, 2})), std::nullopt);
}

struct Choice {
  double sum_of_f = 0, common = 0, good = 0;
};

/// Every way to assign detections to objects.
std::vector<Choice> all_choices(const Contingency& table) {
  const std::vector<bool> detection = detections(table, Regions::kObjects);
  std::vector<Choice> choices;
  const auto extend = [&](const auto& self, std::uint32_t region, Choice choice, std::vector<bool> taken) -> void {
    if (region == table.regions.size()) return choices.push_back(choice);
    self(self, region + 1, choice, taken);
    if (table.regions[region].label < kFirstObjectLabel) return;
    for (const Overlap& o : table.overlaps) {
      if (o.region != region || !detection[o.segment] || taken[o.segment]) continue;
      std::vector<bool> with = taken;
      with[o.segment] = true;
      const double common = static_cast<double>(o.points);
      const double f =
          2 * common / static_cast<double>(table.regions[o.region].points + table.segments[o.segment].points);
      self(self, region + 1, {choice.sum_of_f + f, choice.common + common, choice.good + (f >= 0.75 ? 1 : 0)}, with);
    }
  };
  extend(extend, 0, {}, std::vector<bool>(table.segments.size(), false));
  return choices;
}

TEST(OverlapScores, AreThoseOfABestChoiceOfAllOnRandomLabels) {
  Random random(2);
  for (int round = 0; round < 200; ++round) {
    const auto [truth, labels] = random_labels(random);
    const Contingency table = *tabulate(truth, labels);
    const auto s = overlap_scores(table);
    const double objects = count_objects(table).objects;
    ASSERT_EQ(s.has_value(), objects > 0);
    if (!s) continue;
    const std::vector<Choice> choices = all_choices(table);
    const double best = std::ranges::max(choices, {}, &Choice::sum_of_f).sum_of_f;
    const auto wanted = std::ranges::count_if(truth, [](std::uint32_t t) { return t >= kFirstObjectLabel; });
    EXPECT_TRUE(std::ranges::any_of(choices, [&](const Choice& c) {
      return c.sum_of_f > best - 1e-9 && std::abs(c.common - s->recall * static_cast<double>(wanted)) < 1e-9 &&
             std::abs(c.good - s->objects_f75 * objects) < 1e-9;
    }));
    if (s->precision && *s->precision + s->recall > 0) {
      EXPECT_NEAR(s->f, 2 * *s->precision * s->recall / (*s->precision + s->recall), 1e-12);
    }
  }
}

TEST(OverlapScores, OfTheGroundTruthItselfArePerfect) {
  const OverlapScores s = scores_of({1, 1, 10, 11, 11, 0}, {1, 1, 10, 11, 11, 3});
  EXPECT_EQ(*s.precision, 1);
  EXPECT_EQ(s.recall, 1);
  EXPECT_EQ(s.f, 1);
  EXPECT_EQ(s.objects_f75, 1);
}

}  // namespace
}  // namespace segserve::eval
