#include "segserve/segctl/local.hpp"

#include <utility>

#include "segserve/pipeline/segment.hpp"

namespace segserve::segctl {

absl::StatusOr<client::Result> segment_locally(const codec::LabelledCloud& scene, const Options& options,
                                               const StopToken& stop) {
  auto segmentation = segment(scene.cloud, options, stop);
  if (!segmentation.ok()) return segmentation.status();
  const double total = segmentation->timings.total;
  client::Result result =
      wire::make_result(*std::move(segmentation), scene.cloud, options, scene.view_rule, SEGSERVE_VERSION);
  result.timings.total = total;
  return result;
}

}  // namespace segserve::segctl
