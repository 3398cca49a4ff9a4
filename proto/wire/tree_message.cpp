// SPDX-License-Identifier: Apache-2.0
#include "proto/wire/tree_message.hpp"

#include <algorithm>
#include <limits>
#include <numeric>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/base/status_macros.hpp"
#include "core/codec/common/scalar_type.hpp"
#include "fmt/format.h"
#include "proto/wire/block_message.hpp"
#include "proto/wire/integers_message.hpp"
#include "proto/wire/status_message.hpp"

namespace segserve::wire {
namespace {

// The largest value that a column may hold. `complete` checks the values row by row.
constexpr std::uint32_t kAnyValue = std::numeric_limits<std::uint32_t>::max();

absl::StatusOr<v1::Block> weight_block(const std::vector<double>& weights, v1::Compression compression) {
  return to_block({reinterpret_cast<const char*>(weights.data()), weights.size() * sizeof(double)}, compression);
}

absl::StatusOr<std::vector<double>> read_weights(const v1::Block& message, std::uint64_t count) {
  std::string buffer;
  ASSIGN_OR_RETURN(const std::string_view bytes, block_bytes(message, count * sizeof(double), "tree.weight", buffer));
  std::vector<double> weights(count);
  const auto* in = reinterpret_cast<const std::byte*>(bytes.data());
  for (std::size_t i = 0; i < count; ++i) weights[i] = codec::load<double>(in + i * sizeof(double));
  return weights;
}

}  // namespace

absl::StatusOr<v1::MergeTree> to_message(const MergeTree& tree, v1::Compression compression) {
  v1::MergeTree message;
  ASSIGN_OR_RETURN(*message.mutable_leaf_points(), to_message(tree.leaf_points, compression));
  ASSIGN_OR_RETURN(*message.mutable_left(), to_message(tree.left, compression));
  ASSIGN_OR_RETURN(*message.mutable_right(), to_message(tree.right, compression));
  ASSIGN_OR_RETURN(*message.mutable_weight(), weight_block(tree.weight, compression));
  message.set_merged_rows(static_cast<std::uint32_t>(std::ranges::count(tree.kind, MergeKind::kMerged)));
  return message;
}

absl::StatusOr<MergeTree> from_message(const v1::MergeTree& message, std::uint32_t supervoxels, std::uint64_t points) {
  const std::uint64_t rows = supervoxels == 0 ? 0 : supervoxels - 1;
  TreeColumns columns;
  columns.merged_rows = message.merged_rows();
  ASSIGN_OR_RETURN(columns.leaf_points,
                   from_message(message.leaf_points(), supervoxels, kAnyValue, "tree.leaf_points"));
  ASSIGN_OR_RETURN(columns.left, from_message(message.left(), rows, kAnyValue, "tree.left"));
  ASSIGN_OR_RETURN(columns.right, from_message(message.right(), rows, kAnyValue, "tree.right"));
  ASSIGN_OR_RETURN(columns.weight, read_weights(message.weight(), rows));
  const std::uint64_t sum = std::accumulate(columns.leaf_points.begin(), columns.leaf_points.end(), std::uint64_t{0});
  if (sum != points)
    return malformed(fmt::format("tree.leaf_points: the sum is {} points, but must be {}", sum, points));
  absl::StatusOr<MergeTree> tree = complete(std::move(columns));
  if (!tree.ok()) return malformed(std::string(tree.status().message()));
  return tree;
}

}  // namespace segserve::wire
