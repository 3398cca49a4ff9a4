// SPDX-License-Identifier: Apache-2.0
#include "proto/wire/payload_blocks.hpp"

#include <limits>

namespace segserve::wire {
namespace {

using v1::Block;

/// The blocks that are there, in canonical order.
std::vector<const Block*> blocks(const v1::Cloud& message) {
  std::vector<const Block*> all;
  const auto add = [&all](bool present, const Block& block) {
    if (present) all.push_back(&block);
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
  return all;
}

}  // namespace

std::vector<std::string*> payload_blocks(v1::Cloud& message) {
  std::vector<std::string*> data;
  // The message is ours to change, so its blocks are.
  for (const Block* block : blocks(message)) data.push_back(const_cast<Block*>(block)->mutable_data());
  return data;
}

std::vector<std::uint64_t> payload_block_sizes(const v1::Cloud& message) {
  std::vector<std::uint64_t> sizes;
  for (const Block* block : blocks(message)) sizes.push_back(block->encoded_bytes());
  return sizes;
}

std::uint64_t payload_bytes(const v1::Cloud& message) {
  std::uint64_t sum = 0;
  for (const std::uint64_t size : payload_block_sizes(message)) {
    constexpr std::uint64_t kMost = std::numeric_limits<std::uint64_t>::max();
    sum = size > kMost - sum ? kMost : sum + size;
  }
  return sum;
}

}  // namespace segserve::wire
