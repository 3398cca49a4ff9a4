// SPDX-License-Identifier: Apache-2.0
#include "proto/wire/result_blocks.hpp"

namespace segserve::wire {

std::vector<std::string*> result_blocks(v1::SegmentationResult& message) {
  std::vector<std::string*> blocks;
  if (message.has_labels()) blocks.push_back(message.mutable_labels()->mutable_data()->mutable_data());
  if (message.has_supervoxels()) blocks.push_back(message.mutable_supervoxels()->mutable_data()->mutable_data());
  if (message.has_tree()) {
    v1::MergeTree& tree = *message.mutable_tree();
    for (v1::IntegerArray* column : {tree.mutable_leaf_points(), tree.mutable_left(), tree.mutable_right()}) {
      blocks.push_back(column->mutable_data()->mutable_data());
    }
    blocks.push_back(tree.mutable_weight()->mutable_data());
  }
  if (message.has_selected()) blocks.push_back(message.mutable_selected()->mutable_data()->mutable_data());
  return blocks;
}

std::vector<std::uint64_t> result_block_sizes(const v1::SegmentationResult& message) {
  std::vector<std::uint64_t> sizes;
  if (message.has_labels()) sizes.push_back(message.labels().data().encoded_bytes());
  if (message.has_supervoxels()) sizes.push_back(message.supervoxels().data().encoded_bytes());
  if (message.has_tree()) {
    const v1::MergeTree& tree = message.tree();
    for (const v1::IntegerArray* column : {&tree.leaf_points(), &tree.left(), &tree.right()}) {
      sizes.push_back(column->data().encoded_bytes());
    }
    sizes.push_back(tree.weight().encoded_bytes());
  }
  if (message.has_selected()) sizes.push_back(message.selected().data().encoded_bytes());
  return sizes;
}

}  // namespace segserve::wire
