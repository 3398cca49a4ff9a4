#include "server/segmenter_interface.hpp"

namespace segserve::server {
namespace {

class CoreSegmenter final : public SegmenterInterface {
 public:
  absl::StatusOr<Segmentation> segment(const CloudView& cloud, const Options& options, const StopToken& stop) override {
    return segmenter_.segment(cloud, options, stop);
  }

 private:
  Segmenter segmenter_;
};

}  // namespace

SegmenterFactory core_segmenter_factory() {
  return [] { return std::make_unique<CoreSegmenter>(); };
}

}  // namespace segserve::server
