#include "segserve/eval/contingency.hpp"

#include <algorithm>
#include <unordered_map>

#include "fmt/format.h"

namespace segserve::eval {
namespace {

std::uint32_t index_of(std::vector<Part>& parts, std::uint32_t label) {
  auto part = std::ranges::lower_bound(parts, label, {}, &Part::label);
  if (part == parts.end() || part->label != label) part = parts.insert(part, {label, 0});
  return static_cast<std::uint32_t>(part - parts.begin());
}

}  // namespace

absl::StatusOr<Contingency> tabulate(std::span<const std::uint32_t> truth, std::span<const std::uint32_t> labels) {
  if (truth.size() != labels.size()) {
    return absl::InvalidArgumentError(
        fmt::format("{} points have ground truth, {} have labels", truth.size(), labels.size()));
  }
  std::unordered_map<std::uint64_t, std::uint64_t> joint;  // (truth, label) -> points
  for (std::size_t i = 0; i < truth.size(); ++i) {
    if (truth[i] != 0) ++joint[std::uint64_t{truth[i]} << 32U | labels[i]];
  }
  if (joint.empty()) return absl::InvalidArgumentError("no point has a ground-truth label other than 0");

  Contingency table;
  std::vector<std::pair<std::uint64_t, std::uint64_t>> pairs(joint.begin(), joint.end());
  std::ranges::sort(pairs);
  for (const auto& [pair, points] : pairs) {
    index_of(table.regions, static_cast<std::uint32_t>(pair >> 32U));
    index_of(table.segments, static_cast<std::uint32_t>(pair));
  }
  for (const auto& [pair, points] : pairs) {
    const Overlap overlap{index_of(table.regions, static_cast<std::uint32_t>(pair >> 32U)),
                          index_of(table.segments, static_cast<std::uint32_t>(pair)), points};
    table.regions[overlap.region].points += points;
    table.segments[overlap.segment].points += points;
    table.points += points;
    table.overlaps.push_back(overlap);
  }
  return table;
}

}  // namespace segserve::eval
