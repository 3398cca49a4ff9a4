// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/lab/eval/degrade.hpp"
#include "core/lab/eval/evaluation.hpp"
#include "core/lab/eval/partition_metrics.hpp"
#include "segserve/codec/read_options.hpp"

namespace segserve::eval {

/// The largest width of a thumbnail in pixels.
inline constexpr std::uint32_t kThumbnailWidth = 320;

/// Two pictures of a scene of the same size, as PNG.
struct Thumbnails {
  std::string file;      ///< The scene's name within the folder.
  std::string truth;     ///< The ground truth; what is not scored is gray.
  std::string segments;  ///< The segments, in the colors of matching_labels.
};

/// The names of at most `count` scenes with the smallest paper_objects.wov, smallest first (ties in their order).
/// Scenes without objects are left out.
std::vector<std::string> worst_scenes(std::span<const SceneScores> scenes, std::size_t count);

/// Labels for a picture beside that of the ground truth: a segment takes the label of the region with which its
/// intersection over union is above 0.5, if there is one, and any other segment a label that no region has. Label 0
/// stays. Both arrays have one entry per point.
std::vector<std::uint32_t> matching_labels(std::span<const std::uint32_t> truth, std::span<const std::uint32_t> labels);

/// Segments a scene once more, and draws it. Errors are those of load_scene and `segment`.
absl::StatusOr<Thumbnails> make_thumbnails(const std::filesystem::path& path, const Degradation& degradation,
                                           const SegmentScene& segment, const codec::ReadOptions& read = {});

}  // namespace segserve::eval
