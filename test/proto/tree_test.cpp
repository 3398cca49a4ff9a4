#include "segserve/wire/tree.hpp"

#include "gmock/gmock.h"
#include "segserve/wire/status.hpp"
#include "test/proto/examples.hpp"

namespace segserve::wire {
namespace {

ErrorReason reason_of(const v1alpha1::MergeTree& message) { return details_of(from_message(message).status()).reason; }

TEST(WireTree, RoundTrips) {
  EXPECT_EQ(from_message(to_message(small_tree())).value(), small_tree());
  EXPECT_EQ(from_message(to_message(MergeTree{})).value(), MergeTree{});
}

TEST(WireTree, RefusesKindsItDoesNotKnow) {
  v1alpha1::MergeTree message = to_message(small_tree());
  message.set_kind(0, v1alpha1::MERGE_KIND_UNSPECIFIED);
  EXPECT_EQ(reason_of(message), v1alpha1::ERROR_REASON_MALFORMED_PAYLOAD);
}

TEST(WireTree, RefusesWhatIsNoTree) {
  v1alpha1::MergeTree short_column = to_message(small_tree());
  short_column.mutable_weight()->RemoveLast();
  EXPECT_EQ(reason_of(short_column), v1alpha1::ERROR_REASON_MALFORMED_PAYLOAD);

  v1alpha1::MergeTree loop = to_message(small_tree());
  loop.set_right(0, 4);  // its own parent
  EXPECT_EQ(reason_of(loop), v1alpha1::ERROR_REASON_MALFORMED_PAYLOAD);
}

}  // namespace
}  // namespace segserve::wire
