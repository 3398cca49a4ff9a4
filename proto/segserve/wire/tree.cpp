#include "segserve/wire/tree.hpp"

#include <vector>

#include "fmt/format.h"
#include "segserve/wire/status.hpp"

namespace segserve::wire {
namespace {

template <typename Values, typename Field>
void copy(const Values& from, Field* to) {
  to->Assign(from.begin(), from.end());
}

template <typename Field>
auto to_vector(const Field& field) {
  return std::vector<typename Field::value_type>(field.begin(), field.end());
}

}  // namespace

v1alpha1::MergeTree to_message(const MergeTree& tree) {
  v1alpha1::MergeTree message;
  copy(tree.leaf_points, message.mutable_leaf_points());
  copy(tree.left, message.mutable_left());
  copy(tree.right, message.mutable_right());
  copy(tree.weight, message.mutable_weight());
  copy(tree.height, message.mutable_height());
  copy(tree.leaves, message.mutable_leaves());
  copy(tree.points, message.mutable_points());
  message.mutable_kind()->Reserve(static_cast<int>(tree.kind.size()));
  for (const MergeKind kind : tree.kind) {
    message.add_kind(kind == MergeKind::kMerged ? v1alpha1::MERGE_KIND_MERGED : v1alpha1::MERGE_KIND_JOINED);
  }
  return message;
}

absl::StatusOr<MergeTree> from_message(const v1alpha1::MergeTree& message) {
  MergeTree tree{.leaf_points = to_vector(message.leaf_points()),
                 .left = to_vector(message.left()),
                 .right = to_vector(message.right()),
                 .weight = to_vector(message.weight()),
                 .height = to_vector(message.height()),
                 .leaves = to_vector(message.leaves()),
                 .points = to_vector(message.points()),
                 .kind = {}};
  tree.kind.reserve(static_cast<std::size_t>(message.kind_size()));
  for (const int kind : message.kind()) {
    if (kind != v1alpha1::MERGE_KIND_MERGED && kind != v1alpha1::MERGE_KIND_JOINED) {
      return with_reason(absl::InvalidArgumentError(fmt::format("tree.kind: {} is no kind of merge", kind)),
                         v1alpha1::ERROR_REASON_MALFORMED_PAYLOAD);
    }
    tree.kind.push_back(kind == v1alpha1::MERGE_KIND_MERGED ? MergeKind::kMerged : MergeKind::kJoined);
  }
  if (absl::Status status = check(tree); !status.ok()) {
    return with_reason(std::move(status), v1alpha1::ERROR_REASON_MALFORMED_PAYLOAD);
  }
  return tree;
}

}  // namespace segserve::wire
