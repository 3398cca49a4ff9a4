// SPDX-License-Identifier: Apache-2.0
#include "proto/wire/tree_message.hpp"

#include <algorithm>
#include <limits>
#include <numeric>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/codec/common/scalar_type.hpp"
#include "fmt/format.h"
#include "proto/wire/block_message.hpp"
#include "proto/wire/integers_message.hpp"
#include "proto/wire/status_message.hpp"

namespace segserve::wire {
namespace {

absl::Status put(const std::vector<std::uint32_t>& values, v1::Compression compression, v1::IntegerArray* array) {
  absl::StatusOr<v1::IntegerArray> made = to_message(values, compression);
  if (!made.ok()) return made.status();
  *array = *std::move(made);
  return absl::OkStatus();
}

absl::Status put(const std::vector<double>& values, v1::Compression compression, v1::Block* block) {
  std::string bytes(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(double));
  absl::StatusOr<v1::Block> made = to_block(std::move(bytes), compression);
  if (!made.ok()) return made.status();
  *block = *std::move(made);
  return absl::OkStatus();
}

absl::Status read(const v1::IntegerArray& message, std::uint64_t count, std::string_view name,
                  std::vector<std::uint32_t>& values) {
  constexpr std::uint32_t kAny = std::numeric_limits<std::uint32_t>::max();  // `complete` judges them row by row
  absl::StatusOr<std::vector<std::uint32_t>> made = from_message(message, count, kAny, name);
  if (!made.ok()) return made.status();
  values = *std::move(made);
  return absl::OkStatus();
}

absl::Status read(const v1::Block& message, std::uint64_t count, std::string_view name, std::vector<double>& values) {
  std::string buffer;
  const absl::StatusOr<std::string_view> bytes = block_bytes(message, count * sizeof(double), name, buffer);
  if (!bytes.ok()) return bytes.status();
  values.resize(count);
  const auto* in = reinterpret_cast<const std::byte*>(bytes->data());
  for (std::size_t i = 0; i < count; ++i) values[i] = codec::load<double>(in + i * sizeof(double));
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<v1::MergeTree> to_message(const MergeTree& tree, v1::Compression compression) {
  v1::MergeTree message;
  absl::Status status = put(tree.leaf_points, compression, message.mutable_leaf_points());
  if (status.ok()) status = put(tree.left, compression, message.mutable_left());
  if (status.ok()) status = put(tree.right, compression, message.mutable_right());
  if (status.ok()) status = put(tree.weight, compression, message.mutable_weight());
  if (!status.ok()) return status;
  message.set_merged_rows(static_cast<std::uint32_t>(std::ranges::count(tree.kind, MergeKind::kMerged)));
  return message;
}

absl::StatusOr<MergeTree> from_message(const v1::MergeTree& message, std::uint32_t supervoxels, std::uint64_t points) {
  const std::uint64_t rows = supervoxels == 0 ? 0 : supervoxels - 1;
  TreeColumns columns;
  columns.merged_rows = message.merged_rows();
  absl::Status status = read(message.leaf_points(), supervoxels, "tree.leaf_points", columns.leaf_points);
  if (status.ok()) status = read(message.left(), rows, "tree.left", columns.left);
  if (status.ok()) status = read(message.right(), rows, "tree.right", columns.right);
  if (status.ok()) status = read(message.weight(), rows, "tree.weight", columns.weight);
  if (!status.ok()) return status;
  const std::uint64_t sum = std::accumulate(columns.leaf_points.begin(), columns.leaf_points.end(), std::uint64_t{0});
  if (sum != points) return malformed(fmt::format("tree.leaf_points: {} points of {}", sum, points));
  absl::StatusOr<MergeTree> tree = complete(std::move(columns));
  if (!tree.ok()) return malformed(std::string(tree.status().message()));
  return tree;
}

}  // namespace segserve::wire
