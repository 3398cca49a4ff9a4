// SPDX-License-Identifier: Apache-2.0
#include "core/lab/synth/visible_parts.hpp"

#include <gmock/gmock.h>

namespace segserve::synth {
namespace {

using testing::ElementsAreArray;
using Labels = std::vector<std::uint32_t>;

TEST(VisiblePartsTest, PartsThatDoNotTouchGetLabelsByDescendingSize) {
  Labels label{20, 1, 20, 20,  //
               20, 1, 20, 20,  //
               1,  1, 30, 30};
  label_visible_parts(4, 3, 1, label);
  EXPECT_THAT(label, ElementsAreArray(Labels{21, 1, 20, 20,  //
                                             21, 1, 20, 20,  //
                                             1, 1, 30, 30}));
}

TEST(VisiblePartsTest, CornersTouch) {
  Labels label{20, 0,  20,  //
               0,  20, 0};
  const Labels before = label;
  label_visible_parts(3, 2, 1, label);
  EXPECT_EQ(label, before);
}

TEST(VisiblePartsTest, TheRowsOfThePictureDoNotWrap) {
  Labels label{1,  1, 20,  //
               20, 1, 1};
  label_visible_parts(3, 2, 1, label);
  EXPECT_THAT(label, ElementsAreArray(Labels{1, 1, 20,  //
                                             21, 1, 1}));
}

TEST(VisiblePartsTest, SpecksKeepTheFirstLabel) {
  Labels label{20, 20, 1, 20};
  label_visible_parts(4, 1, 2, label);
  EXPECT_THAT(label, ElementsAreArray(Labels{20, 20, 1, 20}));
}

TEST(VisiblePartsTest, NeverRunsIntoTheNextObject) {
  Labels label;
  for (int i = 0; i < 15; ++i) {
    label.push_back(20);
    label.push_back(1);
  }
  label_visible_parts(30, 1, 1, label);
  for (std::size_t i = 0; i < 30; i += 2) {
    EXPECT_GE(label[i], 20U);
    EXPECT_LE(label[i], 29U);
  }
}

TEST(VisiblePartsTest, SupportIsNotDivided) {
  Labels label{1, 20, 1};
  label_visible_parts(3, 1, 1, label);
  EXPECT_THAT(label, ElementsAreArray(Labels{1, 20, 1}));
}

}  // namespace
}  // namespace segserve::synth
