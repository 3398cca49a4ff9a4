#include "segserve/wire/request.hpp"

#include <string>
#include <utility>
#include <vector>

#include "fmt/format.h"
#include "segserve/wire/cloud.hpp"
#include "segserve/wire/options.hpp"
#include "segserve/wire/status.hpp"

namespace segserve::wire {
namespace {

constexpr std::size_t kMaxIdBytes = 256;

void check_id(const std::string& id, const char* field, std::vector<FieldViolation>& faults) {
  if (id.size() > kMaxIdBytes) {
    faults.push_back({field, fmt::format("has {} bytes, more than {}", id.size(), kMaxIdBytes)});
  }
}

Outputs parse_outputs(const v1alpha1::SegmentRequest& request) {
  if (!request.has_outputs()) return {};
  const v1alpha1::Outputs& message = request.outputs();
  Outputs outputs{.labels = message.labels(), .supervoxels = message.supervoxels(), .tree = message.tree()};
  for (const int accepted : message.accepted_compressions()) {
    if (accepted == v1alpha1::COMPRESSION_ZSTD) outputs.compression = v1alpha1::COMPRESSION_ZSTD;
  }
  return outputs;
}

}  // namespace

v1alpha1::Outputs to_message(const Outputs& outputs) {
  v1alpha1::Outputs message;
  message.set_labels(outputs.labels);
  message.set_supervoxels(outputs.supervoxels);
  message.set_tree(outputs.tree);
  message.add_accepted_compressions(outputs.compression);
  return message;
}

absl::StatusOr<ParsedRequest> parse_request(const v1alpha1::SegmentRequest& request, const Options& defaults) {
  std::vector<FieldViolation> faults;
  check_id(request.request_id(), "request_id", faults);
  check_id(request.frame_id(), "frame_id", faults);
  if (request.has_cloud()) {
    for (FieldViolation& fault : violations(request.cloud())) faults.push_back(std::move(fault));
  } else {
    faults.push_back({"cloud", "missing"});
  }
  ParsedRequest parsed{from_message(request.options(), defaults, faults), parse_outputs(request)};
  if (!faults.empty()) return invalid_fields(faults);
  return parsed;
}

}  // namespace segserve::wire
