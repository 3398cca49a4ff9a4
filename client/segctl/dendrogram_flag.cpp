// SPDX-License-Identifier: Apache-2.0
#include "client/segctl/dendrogram_flag.hpp"

#include <memory>

#include "client/segctl/output_kind.hpp"
#include "core/base/status_macros.hpp"
#include "core/lab/picture/dendrogram.hpp"
#include "core/lab/picture/picture.hpp"
#include "core/lab/picture/segment_colors.hpp"

namespace segserve::segctl {

void DendrogramFlag::add_to(CLI::App& app) {
  app.add_option(
         "--dendrogram", path_,
         "write a picture of the merge tree, with the cut and the colors of --picture: PNG; - is standard output")
      ->type_name("FILE")
      ->group("Output");
}

absl::Status DendrogramFlag::announce(StagedOutput& output) const {
  if (path_.empty()) return absl::OkStatus();
  RETURN_IF_ERROR(output.announce(path_));
  return check_output_name("--dendrogram", path_, OutputKind::kPicture);
}

absl::Status DendrogramFlag::add(StagedOutput& output, const client::Result& result, const codec::LabeledCloud* scene,
                                 const SceneOutput& scene_output) const {
  if (path_.empty()) return absl::OkStatus();
  const Segmentation& segmentation = result.segmentation;
  picture::SegmentColors colors;
  if (scene != nullptr) {
    ASSIGN_OR_RETURN(const picture::RenderOptions options, scene_output.render_options(*scene));
    colors = picture::colors_in_picture(scene->cloud, segmentation.labels, options);
  }
  picture::DendrogramOptions options;
  options.regions = result.regions;
  if (!result.regions) options.threshold = segmentation.threshold;
  const auto segments =
      picture::segments_of_leaves(segmentation.tree.leaf_count(), segmentation.supervoxels, segmentation.labels);
  auto image =
      std::make_shared<const picture::Image>(picture::draw_dendrogram(segmentation.tree, segments, colors, options));
  output.add(path_, [image](const std::string& target) { return picture::write_png(target, *image); });
  return absl::OkStatus();
}

}  // namespace segserve::segctl
