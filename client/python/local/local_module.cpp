// SPDX-License-Identifier: Apache-2.0
// The module segserve._local: the segmentation in the process of Python. segserve/local.py is its only user.
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/base/exception_status.hpp"
#include "core/base/status_macros.hpp"
#include "proto/wire/cloud_message.hpp"
#include "proto/wire/integers_message.hpp"
#include "proto/wire/options_message.hpp"
#include "proto/wire/payload/payload_support.hpp"
#include "proto/wire/payload_blocks.hpp"
#include "proto/wire/prompts_message.hpp"
#include "proto/wire/result_message.hpp"
#include "proto/wire/status_message.hpp"
#include "segserve/codec/planar.hpp"
#include "segserve/segment.hpp"

namespace segserve {
namespace {

namespace py = pybind11;
using Clock = std::chrono::steady_clock;

/// A segmentation to do, as messages of the API. The blocks are the bytes of the cloud's payload, in Python's memory.
struct Job {
  v1::Cloud cloud;
  v1::SegmentOptions options;
  v1::Outputs outputs;
  std::optional<v1::Prompts> prompts;
  std::vector<std::string_view> blocks;
  StopToken stop;
};

struct Done {
  v1::SegmentationResult message;  ///< without labels and supervoxels
  std::vector<std::uint32_t> labels, supervoxels;
};

double milliseconds_since(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

/// Whether the cloud can be segmented where it is.
bool is_raw_planar(const v1::Cloud& cloud) {
  return cloud.has_planar() && cloud.planar().x().compression() == v1::COMPRESSION_NONE &&
         cloud.unit() == v1::LENGTH_UNIT_UNSPECIFIED;
}

/// Decodes as a server does. Raw planes are not copied; other payloads are moved into the message first.
absl::StatusOr<wire::DecodedCloud> decode(Job& job) {
  v1::Cloud& cloud = job.cloud;
  if (!is_raw_planar(cloud)) {
    const std::vector<std::string*> data = wire::payload_blocks(cloud);
    for (std::size_t i = 0; i < data.size(); ++i) data[i]->assign(job.blocks[i]);
    return wire::decode_cloud(cloud, {}, job.stop);
  }
  std::vector<FieldViolation> faults;
  const std::optional<View> view = wire::from_message(cloud.view(), faults);
  RETURN_IF_ERROR(wire::invalid_fields(faults));
  const bool has_color = job.blocks.size() > 3;
  const codec::PlanarBytes planes{job.blocks[0], job.blocks[1], job.blocks[2],
                                  has_color ? job.blocks[3] : std::string_view()};
  ASSIGN_OR_RETURN(BorrowingCloud borrowed, wire::with_decode_reason(codec::decode_planar(
                                                planes, cloud.width(), cloud.height(), *view, {}, job.stop)));
  return wire::DecodedCloud{std::move(borrowed), wire::requested_view_rule(*view)};
}

absl::StatusOr<Done> run(Job& job) {
  const Clock::time_point start = Clock::now();
  std::vector<FieldViolation> faults;
  const Options given = wire::from_message(job.options, {}, faults);
  const auto prompts = job.prompts ? std::optional(wire::from_message(*job.prompts, faults)) : std::nullopt;
  RETURN_IF_ERROR(wire::invalid_fields(faults));
  ASSIGN_OR_RETURN(const wire::DecodedCloud decoded, decode(job));
  const double decode_ms = milliseconds_since(start);
  const Options options = codec::to_cloud(decoded.placement, given);
  RETURN_IF_ERROR(wire::invalid_fields(wire::violations_in_view(options, decoded.cloud->view)));

  absl::StatusOr<Segmentation> segmented = segment(decoded.cloud, options, job.stop);
  if (absl::IsInvalidArgument(segmented.status())) {  // the options were checked before
    return wire::with_reason(segmented.status(), wire::ErrorReason::kInvalidCloud);
  }
  RETURN_IF_ERROR(segmented.status());
  Segmentation& segmentation = *segmented;
  if (job.outputs.segments()) RETURN_IF_ERROR(describe(decoded.cloud, given.threads, job.stop, segmentation));
  const wire::Outputs rest{.labels = false, .tree = job.outputs.tree(), .segments = job.outputs.segments()};
  ASSIGN_OR_RETURN(auto selection, wire::select_by_prompts(decoded.cloud, decoded.placement, segmentation, given, rest,
                                                           prompts, job.stop));
  Done done;
  if (job.outputs.labels()) done.labels = std::move(segmentation.labels);
  if (job.outputs.supervoxels()) done.supervoxels = std::move(segmentation.supervoxels);
  wire::Result result =
      wire::make_result(std::move(segmentation), decoded.cloud, given, decoded.view_rule, SEGSERVE_VERSION);
  result.selection = std::move(selection);
  wire::take_payload_facts(decoded.placement, decoded.warnings, result);
  result.timings.decode = decode_ms;
  ASSIGN_OR_RETURN(done.message, wire::to_message(result, rest));
  if (result.selection && job.outputs.labels()) {
    ASSIGN_OR_RETURN(*done.message.mutable_selected(),
                     wire::to_message(result.selection->labels, v1::COMPRESSION_NONE));
  }
  wire::set_final_timings(done.message, 0, milliseconds_since(start));
  return done;
}

absl::StatusOr<Done> run_without_exceptions(Job& job) {
  try {
    return run(job);
  } catch (...) {
    return exception_status("segment the cloud in this process");
  }
}

/// An array that owns the values, which are not copied.
py::array_t<std::uint32_t> to_array(std::vector<std::uint32_t> values) {
  auto owner = std::make_unique<std::vector<std::uint32_t>>(std::move(values));
  std::uint32_t* const data = owner->data();
  const auto size = static_cast<py::ssize_t>(owner->size());
  const py::capsule guard(owner.release(), [](void* kept) { delete static_cast<std::vector<std::uint32_t>*>(kept); });
  return py::array_t<std::uint32_t>(size, data, guard);
}

/// The arguments are serialized messages, the buffers of the blocks, prompts or None, and the seconds that are left.
/// Returns a serialized google.rpc.Status, which is empty if all went well, the serialized result, labels and
/// supervoxels.
py::tuple segment_payload(const std::string& cloud, const std::vector<py::buffer>& blocks, const std::string& options,
                          const std::string& outputs, const std::optional<std::string>& prompts, double seconds) {
  const auto limit = std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
  Job job;
  job.stop = StopToken(nullptr, Clock::now() + limit);
  std::vector<py::buffer_info> kept;  // so that Python leaves the buffers where they are
  for (const py::buffer& block : blocks) {
    const py::buffer_info& info = kept.emplace_back(block.request());
    job.blocks.emplace_back(static_cast<const char*>(info.ptr), static_cast<std::size_t>(info.size * info.itemsize));
  }
  const bool parsed = job.cloud.ParseFromString(cloud) && job.options.ParseFromString(options) &&
                      job.outputs.ParseFromString(outputs) &&
                      (!prompts || job.prompts.emplace().ParseFromString(*prompts));
  if (!parsed || job.blocks.size() != wire::payload_blocks(job.cloud).size()) {
    throw py::value_error("the arguments are no messages of segserve.v1, or the blocks do not fit the cloud");
  }
  std::optional<absl::StatusOr<Done>> done;
  {
    const py::gil_scoped_release released;
    done = run_without_exceptions(job);
  }
  if (!done->ok()) {
    return py::make_tuple(py::bytes(wire::to_message(wire::as_told(done->status())).SerializeAsString()), py::bytes(),
                          py::none(), py::none());
  }
  Done& result = **done;
  return py::make_tuple(py::bytes(), py::bytes(result.message.SerializeAsString()), to_array(std::move(result.labels)),
                        to_array(std::move(result.supervoxels)));
}

}  // namespace
}  // namespace segserve

PYBIND11_MODULE(_local, module) { module.def("segment_payload", &segserve::segment_payload); }
