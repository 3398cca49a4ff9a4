// SPDX-License-Identifier: Apache-2.0
#include "core/lab/eval/thumbnails.hpp"

#include <algorithm>
#include <unordered_map>
#include <utility>

#include "core/base/status_macros.hpp"
#include "core/base/status_text.hpp"
#include "core/lab/eval/contingency.hpp"
#include "core/lab/picture/picture.hpp"
#include "core/lab/picture/segment_colors.hpp"

namespace segserve::eval {
namespace {

/// `colors` are those of the picture beside it, too.
absl::StatusOr<std::string> thumbnail(const CloudView& cloud, std::span<const std::uint32_t> labels,
                                      picture::SegmentColors& colors) {
  const picture::RenderOptions options{.width = kThumbnailWidth, .height = kThumbnailWidth * 3 / 4, .colors = &colors};
  return picture::encode_png(picture::shrink(picture::render(cloud, labels, options), kThumbnailWidth));
}

}  // namespace

std::vector<std::string> worst_scenes(std::span<const SceneScores> scenes, std::size_t count) {
  constexpr std::size_t kMetric = metric("paper_objects.wov");
  std::vector<const SceneScores*> order;
  for (const SceneScores& scene : scenes) {
    if (scene.values[kMetric]) order.push_back(&scene);
  }
  std::ranges::stable_sort(order, {}, [](const SceneScores* scene) { return *scene->values[kMetric]; });
  std::vector<std::string> files;
  for (std::size_t i = 0; i < std::min(count, order.size()); ++i) files.push_back(order[i]->file);
  return files;
}

std::vector<std::uint32_t> matching_labels(std::span<const std::uint32_t> truth,
                                           std::span<const std::uint32_t> labels) {
  std::unordered_map<std::uint32_t, std::uint32_t> color;
  std::uint32_t next = 1;
  if (const auto table = tabulate(truth, labels); table.ok()) {
    for (const Overlap& o : table->overlaps) {
      const std::uint64_t all = table->regions[o.region].points + table->segments[o.segment].points - o.points;
      if (2 * o.points > all) color[table->segments[o.segment].label] = table->regions[o.region].label;
    }
    next = table->regions.back().label + 1;
  }
  color[0] = 0;
  std::vector<std::uint32_t> matching;
  matching.reserve(labels.size());
  for (const std::uint32_t label : labels) {
    const auto [entry, is_new] = color.try_emplace(label, next);
    if (is_new) ++next;
    matching.push_back(entry->second);
  }
  return matching;
}

absl::StatusOr<Thumbnails> make_thumbnails(const std::filesystem::path& path, const Degradation& degradation,
                                           const SegmentScene& segment, const codec::ReadOptions& read) {
  ASSIGN_OR_RETURN(const codec::LabeledCloud scene, load_scene(path, degradation, read));
  const auto partition = segment(scene.cloud);
  if (!partition.ok()) return with_prefix(path.string(), partition.status());
  Thumbnails pictures{path.filename().string(), {}, {}};
  picture::SegmentColors colors;
  ASSIGN_OR_RETURN(pictures.truth, thumbnail(scene.cloud, scene.label, colors));
  ASSIGN_OR_RETURN(pictures.segments, thumbnail(scene.cloud, matching_labels(scene.label, partition->labels), colors));
  return pictures;
}

}  // namespace segserve::eval
