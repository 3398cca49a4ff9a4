// SPDX-License-Identifier: Apache-2.0
#include "client/segctl/segment_many.hpp"

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <filesystem>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "client/segctl/batch.hpp"
#include "client/segctl/output_folder.hpp"
#include "client/segctl/output_kind.hpp"
#include "client/segctl/sheet_collector.hpp"
#include "client/segctl/staged_output.hpp"
#include "core/base/status_macros.hpp"
#include "segserve/v1/segmentation_service.pb.h"

namespace segserve::segctl {
namespace {

constexpr std::size_t kDefaultParallel = 4;
constexpr std::chrono::seconds kLongestOutage{10};

absl::Status prepare_remote(const SegmentArguments& arguments, BatchJob& job) {
  ASSIGN_OR_RETURN(job.client, arguments.server.connect(arguments.fallback_local));
  // Without this, every file would fail for the same reason.
  const absl::Status reached = job.client->server_info().status();
  if (!reached.ok() && !(arguments.fallback_local && absl::IsUnavailable(reached))) return or_locally(reached);
  job.server = arguments.server.address();
  job.stream.client_name = "segctl segment";
  job.stream.options = job.request.options;
  job.stream.outputs = {.labels = true, .segments = job.request.segments};
  job.stream.outputs.compression = answer_compression(job.request.codec);
  job.stream.fallback_to_local = arguments.fallback_local;
  job.stream.frame_timeout = *arguments.server.timeout();
  // Without this limit, every file would wait for its timeout before it fails.
  job.stream.longest_outage = std::min<std::chrono::milliseconds>(kLongestOutage, job.stream.frame_timeout / 2);
  return absl::OkStatus();
}

/// Makes the folder, and the folders within, which tell files of the same name apart.
absl::Status make_folders(const std::string& out_dir, const std::vector<BatchInput>& inputs) {
  RETURN_IF_ERROR(make_folder(out_dir));
  std::set<std::string> folders;
  for (const BatchInput& input : inputs) folders.insert(std::filesystem::path(input.cloud_path).parent_path().string());
  for (const std::string& folder : folders) RETURN_IF_ERROR(make_folder(folder));
  return absl::OkStatus();
}

/// Tells faults of the paths of outputs before the work. Those within the folder are in batch_inputs.
absl::Status check_outputs(const SegmentArguments& arguments, const std::vector<BatchInput>& inputs) {
  StagedOutput output;
  for (const BatchInput& input : inputs) RETURN_IF_ERROR(output.protect({input.path}, true));
  RETURN_IF_ERROR(arguments.json.announce(output));
  if (arguments.contact_sheet.empty()) return absl::OkStatus();
  RETURN_IF_ERROR(output.announce(arguments.contact_sheet));
  return check_output_name("--contact-sheet", arguments.contact_sheet, OutputKind::kPicture);
}

}  // namespace

absl::Status segment_many(const SegmentArguments& arguments) {
  BatchJob job;
  SheetCollector sheet;
  if (!arguments.contact_sheet.empty()) {
    job.sheet_path = arguments.contact_sheet;
    job.sheet = &sheet;
  }
  ASSIGN_OR_RETURN(job.request, arguments.request());
  ASSIGN_OR_RETURN(job.inputs, batch_inputs(arguments.scenes, arguments.out_dir));
  RETURN_IF_ERROR(check_outputs(arguments, job.inputs));
  const std::size_t usual = arguments.local ? std::max(1U, std::thread::hardware_concurrency()) : kDefaultParallel;
  job.parallel = arguments.parallel == 0 ? usual : arguments.parallel;
  job.format = &arguments.scene_output;
  job.json = &arguments.json;
  job.quiet = arguments.quiet;
  if (!arguments.local) RETURN_IF_ERROR(prepare_remote(arguments, job));
  if (!arguments.out_dir.empty()) RETURN_IF_ERROR(make_folders(arguments.out_dir, job.inputs));
  return run_batch(job);
}

}  // namespace segserve::segctl
