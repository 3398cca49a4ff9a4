#include "client/segctl/segment_many.hpp"

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <system_error>
#include <thread>
#include <utility>

#include "client/segctl/batch.hpp"
#include "fmt/format.h"
#include "segserve/v1/server_info.pb.h"

namespace segserve::segctl {
namespace {

absl::Status prepare_remote(const SegmentArguments& arguments, BatchJob& job) {
  auto client = arguments.server.connect(arguments.fallback_local);
  if (!client.ok()) return client.status();
  // Before a run in which every file would fail for the same reason.
  absl::Status reached = client->server_info().status();
  if (!reached.ok() && !(arguments.fallback_local && absl::IsUnavailable(reached))) return reached;
  job.client = *std::move(client);
  job.server = arguments.server.address();
  job.stream.client_name = "segctl segment";
  job.stream.options = job.request.options;
  job.stream.outputs = {.labels = true, .segments = job.request.segments};
  job.stream.outputs.compression = answer_compression(job.request.codec);
  job.stream.fallback_to_local = arguments.fallback_local;
  job.stream.frame_timeout = *arguments.server.timeout();
  return absl::OkStatus();
}

}  // namespace

absl::Status segment_many(const SegmentArguments& arguments) {
  BatchJob job;
  auto request = arguments.request();
  if (!request.ok()) return request.status();
  job.request = *std::move(request);
  std::error_code error;
  if (!std::filesystem::is_directory(arguments.out_dir, error)) {
    return absl::InvalidArgumentError(fmt::format("--out-dir: there is no folder {}", arguments.out_dir));
  }
  auto inputs = batch_inputs(arguments.scenes, arguments.out_dir);
  if (!inputs.ok()) return inputs.status();
  job.inputs = *std::move(inputs);
  const std::size_t usual = arguments.local ? std::max(1U, std::thread::hardware_concurrency()) : 4;
  job.parallel = arguments.parallel == 0 ? usual : arguments.parallel;
  job.format = &arguments.scene_output;
  job.json_path = arguments.json_path;
  job.quiet = arguments.quiet;
  if (!arguments.local) {
    if (absl::Status status = prepare_remote(arguments, job); !status.ok()) return status;
  }
  return run_batch(job);
}

}  // namespace segserve::segctl
