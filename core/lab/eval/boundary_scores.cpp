// SPDX-License-Identifier: Apache-2.0
#include "core/lab/eval/boundary_scores.hpp"

#include <algorithm>
#include <cstddef>
#include <vector>

namespace segserve::eval {
namespace {

using Labels = std::span<const std::uint32_t>;

/// One flag per pixel.
std::vector<bool> boundary_pixels(Labels truth, Labels labels, std::size_t width) {
  std::vector<bool> boundary(truth.size(), false);
  const auto compare = [&](std::size_t a, std::size_t b) {
    if (truth[a] != 0 && truth[b] != 0 && labels[a] != labels[b]) boundary[a] = boundary[b] = true;
  };
  for (std::size_t i = 0; i < truth.size(); ++i) {
    if ((i + 1) % width != 0) compare(i, i + 1);
    if (i + width < truth.size()) compare(i, i + width);
  }
  return boundary;
}

/// Whether a flag is set in the window around pixel i.
bool any_near(const std::vector<bool>& flags, std::size_t i, std::size_t width, std::size_t height) {
  const std::size_t row = i / width;
  const std::size_t column = i % width;
  const auto first = [](std::size_t at) { return at - std::min<std::size_t>(at, kBoundaryTolerance); };
  for (std::size_t r = first(row); r <= std::min(row + kBoundaryTolerance, height - 1); ++r) {
    for (std::size_t c = first(column); c <= std::min(column + kBoundaryTolerance, width - 1); ++c) {
      if (flags[r * width + c]) return true;
    }
  }
  return false;
}

/// The share of the pixels of `wanted` that have a pixel of `found` within the tolerance. Unset if nothing is wanted.
std::optional<double> share_found(const std::vector<bool>& wanted, const std::vector<bool>& found, std::size_t width,
                                  std::size_t height) {
  std::size_t pixels = 0;
  std::size_t near = 0;
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    if (!wanted[i]) continue;
    ++pixels;
    if (any_near(found, i, width, height)) ++near;
  }
  if (pixels == 0) return std::nullopt;
  return static_cast<double>(near) / static_cast<double>(pixels);
}

}  // namespace

std::optional<BoundaryScores> boundary_scores(Labels truth, Labels labels, std::uint32_t width, std::uint32_t height) {
  if (height <= 1) return std::nullopt;
  const std::vector<bool> wanted = boundary_pixels(truth, truth, width);
  const std::vector<bool> found = boundary_pixels(truth, labels, width);
  const auto recall = share_found(wanted, found, width, height);
  if (!recall) return std::nullopt;
  BoundaryScores scores{share_found(found, wanted, width, height), *recall, 0};
  const double sum = scores.precision.value_or(0) + scores.recall;
  if (sum > 0) scores.f = 2 * scores.precision.value_or(0) * scores.recall / sum;
  return scores;
}

std::optional<double> boundary_recall(Labels truth, Labels supervoxels, std::uint32_t width, std::uint32_t height) {
  if (height <= 1) return std::nullopt;
  return share_found(boundary_pixels(truth, truth, width), boundary_pixels(truth, supervoxels, width), width, height);
}

}  // namespace segserve::eval
