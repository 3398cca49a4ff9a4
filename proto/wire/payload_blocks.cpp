// SPDX-License-Identifier: Apache-2.0
#include "proto/wire/payload_blocks.hpp"

#include <algorithm>

#include "proto/wire/byte_run.hpp"

namespace segserve::wire {
namespace {

using v1::Block;

/// The blocks that the payload has, in the order of their fields in cloud.proto.
std::vector<const Block*> blocks_of(const v1::Cloud& message) {
  std::vector<const Block*> blocks;
  const auto add = [&blocks](bool is_present, const Block& block) {
    if (is_present) blocks.push_back(&block);
  };
  switch (message.payload_case()) {
    case v1::Cloud::kPlanar:
      add(message.planar().has_x(), message.planar().x());
      add(message.planar().has_y(), message.planar().y());
      add(message.planar().has_z(), message.planar().z());
      add(message.planar().has_rgb(), message.planar().rgb());
      break;
    case v1::Cloud::kPcdFile:
      add(message.pcd_file().has_file(), message.pcd_file().file());
      break;
    case v1::Cloud::kStrided:
      add(message.strided().has_data(), message.strided().data());
      break;
    case v1::Cloud::kQuantised:
      add(message.quantised().has_data(), message.quantised().data());
      break;
    case v1::Cloud::kRgbd:
      add(message.rgbd().has_depth(), message.rgbd().depth());
      add(message.rgbd().has_color(), message.rgbd().color());
      break;
    case v1::Cloud::kDraco:
      add(message.draco().has_data(), message.draco().data());
      add(message.draco().has_finite(), message.draco().finite());
      break;
    case v1::Cloud::PAYLOAD_NOT_SET:
      break;
  }
  return blocks;
}

}  // namespace

std::vector<std::string*> payload_blocks(v1::Cloud& message) {
  std::vector<std::string*> data;
  // The message is not const, so its blocks may be changed.
  for (const Block* block : blocks_of(message)) data.push_back(const_cast<Block*>(block)->mutable_data());
  return data;
}

bool payload_has_data(const v1::Cloud& message) {
  return std::ranges::any_of(blocks_of(message), [](const Block* block) { return !block->data().empty(); });
}

std::vector<std::uint64_t> payload_block_sizes(const v1::Cloud& message) {
  std::vector<std::uint64_t> sizes;
  for (const Block* block : blocks_of(message)) sizes.push_back(block->encoded_bytes());
  return sizes;
}

std::uint64_t payload_bytes(const v1::Cloud& message) { return saturating_sum(payload_block_sizes(message)); }

}  // namespace segserve::wire
