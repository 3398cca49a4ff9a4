// SPDX-License-Identifier: Apache-2.0
#include "core/lab/eval/instance_scores.hpp"

#include <gmock/gmock.h>

#include <set>

#include "test/core/lab/eval/random_labels.hpp"

namespace segserve::eval {
namespace {

/// Points in the order in which they are added.
class Points {
 public:
  Points& add(std::uint32_t region, std::uint32_t segment, std::size_t count) {
    truth_.insert(truth_.end(), count, region);
    labels_.insert(labels_.end(), count, segment);
    return *this;
  }
  Contingency table() const { return *tabulate(truth_, labels_); }

 private:
  Labels truth_, labels_;
};

/// A table of 100 points, and three objects: 10 is found with an IoU of 18 / 22, 11 is in two halves, and 12 is one
/// with a part of the table.
Points example() {
  return Points().add(1, 1, 80).add(1, 2, 2).add(1, 5, 18).add(10, 2, 18).add(10, 1, 2).add(11, 3, 5).add(11, 4, 5).add(
      12, 5, 12);
}

TEST(Detections, AreSegmentsWithHalfOfTheirPointsInObjects) {
  const Contingency table = example().add(10, 0, 1).add(1, 6, 3).add(11, 6, 3).table();
  // Segments 0 to 6. Segment 5 has 12 of 30 points in objects, segment 6 has 3 of 6.
  EXPECT_THAT(detections(table, Regions::kObjects), testing::ElementsAre(false, false, true, true, true, false, true));
  EXPECT_THAT(detections(table, Regions::kAll), testing::ElementsAre(false, true, true, true, true, true, true));
}

TEST(PanopticScores, CountMatchesAboveOneHalf) {
  // Objects: 10 matches segment 2. The halves of 11 have an IoU of exactly 0.5, which is no match, and 12 has 12 / 30.
  // There are three detections (2, 3, 4) and three objects.
  const auto objects = panoptic_scores(example().table(), Regions::kObjects);
  ASSERT_TRUE(objects);
  EXPECT_DOUBLE_EQ(objects->pq, 18.0 / 22 / 3);
  EXPECT_DOUBLE_EQ(*objects->sq, 18.0 / 22);
  EXPECT_DOUBLE_EQ(objects->rq, 1.0 / 3);
  // All: the table matches segment 1 with 80 / 102. There are five segments and four regions.
  const auto all = panoptic_scores(example().table(), Regions::kAll);
  ASSERT_TRUE(all);
  EXPECT_DOUBLE_EQ(all->pq, (18.0 / 22 + 80.0 / 102) / 4.5);
  EXPECT_DOUBLE_EQ(*all->sq, (18.0 / 22 + 80.0 / 102) / 2);
  EXPECT_DOUBLE_EQ(all->rq, 2 / 4.5);
}

TEST(PanopticScores, DoNotCountWhatWasLeftOut) {
  const Contingency table = Points().add(10, 1, 4).add(10, 0, 1).add(11, 0, 9).table();
  const auto scores = panoptic_scores(table, Regions::kObjects);
  EXPECT_DOUBLE_EQ(scores->pq, 0.8 / 1.5);  // one match, one missed object, no false detection
}

TEST(PanopticScores, HaveNoMeanOverlapWithoutAMatch) {
  const auto scores = panoptic_scores(Points().add(10, 1, 4).add(11, 1, 4).table(), Regions::kObjects);
  EXPECT_EQ(scores->pq, 0);
  EXPECT_EQ(scores->sq, std::nullopt);
  EXPECT_EQ(panoptic_scores(Points().add(1, 1, 4).table(), Regions::kObjects), std::nullopt);
}

TEST(InstanceScores, AreOneStepOfPrecisionAndRecall) {
  // 18 / 22 is above 0.5, 0.55 and so on up to 0.8: seven of ten thresholds. One of three detections is right then, and
  // one of three objects is found.
  const auto scores = instance_scores(example().table());
  ASSERT_TRUE(scores);
  EXPECT_DOUBLE_EQ(scores->ap50, 1.0 / 9);
  EXPECT_DOUBLE_EQ(scores->ap75, 1.0 / 9);
  EXPECT_DOUBLE_EQ(scores->ar50, 1.0 / 3);
  EXPECT_DOUBLE_EQ(scores->ar75, 1.0 / 3);
  EXPECT_DOUBLE_EQ(scores->ap, 0.7 / 9);
  EXPECT_DOUBLE_EQ(scores->ar, 0.7 / 3);
}

TEST(InstanceScores, AreZeroWithoutAMatchAndUnsetWithoutAnObject) {
  const auto none = instance_scores(Points().add(10, 0, 4).table());
  EXPECT_EQ(none->ap, 0);
  EXPECT_EQ(none->ar, 0);
  EXPECT_EQ(instance_scores(Points().add(9, 1, 4).table()), std::nullopt);
}

TEST(CountObjects, TellsSplitFromMergedObjects) {
  // 10 is found: 18 of its 20 points, and 18 of the segment's 20. 11 is in halves. 12 is whole, in a segment that lies
  // 12 / 30 in it.
  ObjectCounts counts = count_objects(example().table());
  EXPECT_EQ(counts.objects, 3U);
  EXPECT_EQ(counts.over_segmented, 1U);
  EXPECT_EQ(counts.under_segmented, 1U);
  EXPECT_EQ(counts.missed, 0U);
  // 13 is both. 14 is missed, while 15 is half missed, so that its segment holds too little of it.
  counts = count_objects(Points()
                             .add(13, 1, 7)
                             .add(1, 1, 7)
                             .add(13, 2, 3)
                             .add(14, 0, 6)
                             .add(14, 3, 4)
                             .add(15, 0, 5)
                             .add(15, 4, 5)
                             .table());
  EXPECT_EQ(counts.objects, 3U);
  EXPECT_EQ(counts.over_segmented, 2U);
  EXPECT_EQ(counts.under_segmented, 1U);
  EXPECT_EQ(counts.missed, 1U);
}

TEST(CountObjects, FindsAnObjectAtEightyPerCent) {
  const auto counts = [](std::size_t common) {  // of an object of 10 points, and of a segment of 10
    return count_objects(Points().add(10, 1, common).add(10, 2, 10 - common).add(1, 1, 10 - common).table());
  };
  EXPECT_EQ(counts(8).over_segmented + counts(8).under_segmented, 0U);
  EXPECT_EQ(counts(7).over_segmented, 1U);
  EXPECT_EQ(counts(7).under_segmented, 1U);
}

using Sets = std::map<std::uint32_t, std::set<std::size_t>>;

/// The points of each label, without those that have no ground truth.
Sets sets_of(const Labels& labels, const Labels& truth) {
  Sets sets;
  for (std::size_t i = 0; i < labels.size(); ++i) {
    if (truth[i] != 0 && labels[i] != 0) sets[labels[i]].insert(i);
  }
  return sets;
}

double iou(const std::set<std::size_t>& a, const std::set<std::size_t>& b) {
  double common = 0;
  for (const std::size_t i : a) common += b.contains(i) ? 1 : 0;
  return common / (static_cast<double>(a.size() + b.size()) - common);
}

TEST(InstanceScores, AndPanopticScoresAreThoseOfSetsOnRandomLabels) {
  Random random(1);
  for (int round = 0; round < 200; ++round) {
    const auto [truth, labels] = random_labels(random);
    const Contingency table = *tabulate(truth, labels);
    Sets objects = sets_of(truth, truth);
    std::erase_if(objects, [](const auto& entry) { return entry.first < kFirstObjectLabel; });
    Sets found = sets_of(labels, truth);
    std::erase_if(found, [&](const auto& entry) {
      std::size_t inside = 0;
      for (const std::size_t i : entry.second) inside += truth[i] >= kFirstObjectLabel ? 1U : 0U;
      return inside * 2 < entry.second.size();
    });
    const auto instances = instance_scores(table);
    ASSERT_EQ(instances.has_value(), !objects.empty());
    if (objects.empty()) continue;

    double ap = 0, ar = 0, pq = 0;
    for (int percent = 50; percent <= 95; percent += 5) {
      double matches = 0, sum = 0;
      for (const auto& [region, points] : objects) {
        for (const auto& [segment, others] : found) {
          const double overlap = iou(points, others);
          if (overlap < percent / 100.0 + 1e-9) continue;
          ++matches;
          sum += overlap;
        }
      }
      const double recall = matches / static_cast<double>(objects.size());
      ar += recall / 10;
      ap += matches == 0 ? 0 : recall * matches / static_cast<double>(found.size()) / 10;
      if (percent == 50) pq = 2 * sum / static_cast<double>(objects.size() + found.size());
    }
    EXPECT_NEAR(instances->ap, ap, 1e-12);
    EXPECT_NEAR(instances->ar, ar, 1e-12);
    EXPECT_NEAR(panoptic_scores(table, Regions::kObjects)->pq, pq, 1e-12);
  }
}

TEST(Scores, OfTheGroundTruthItselfArePerfect) {
  const Contingency table = Points().add(1, 1, 9).add(10, 10, 3).add(11, 11, 1).table();
  EXPECT_DOUBLE_EQ(instance_scores(table)->ap, 1);
  EXPECT_DOUBLE_EQ(instance_scores(table)->ar, 1);
  EXPECT_DOUBLE_EQ(panoptic_scores(table, Regions::kAll)->pq, 1);
  EXPECT_DOUBLE_EQ(panoptic_scores(table, Regions::kObjects)->pq, 1);
}

}  // namespace
}  // namespace segserve::eval
