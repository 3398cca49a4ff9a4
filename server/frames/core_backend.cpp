// SPDX-License-Identifier: Apache-2.0
#include "server/frames/segmentation_backend.hpp"

namespace segserve::server {
namespace {

class CoreBackend final : public SegmentationBackend {
 public:
  absl::StatusOr<Segmentation> segment(const CloudView& cloud, const Options& options, const StopToken& stop,
                                       const Admission& admit) override {
    return segmenter_.segment(cloud, options, stop, admit);
  }

  void free_buffers() override { segmenter_ = Segmenter(); }

 private:
  Segmenter segmenter_;
};

}  // namespace

BackendFactory core_backend_factory() {
  return [] { return std::make_unique<CoreBackend>(); };
}

}  // namespace segserve::server
