#pragma once

#include "absl/status/statusor.h"
#include "segserve/tree/merge_tree.hpp"
#include "segserve/v1alpha1/result.pb.h"

namespace segserve::wire {

v1alpha1::MergeTree to_message(const MergeTree& tree);

/// MALFORMED_PAYLOAD unless the columns describe a tree (core's `check`).
absl::StatusOr<MergeTree> from_message(const v1alpha1::MergeTree& message);

}  // namespace segserve::wire
