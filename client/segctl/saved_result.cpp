// SPDX-License-Identifier: Apache-2.0
#include "client/segctl/saved_result.hpp"

#include <utility>

#include "client/segctl/input_file.hpp"
#include "core/base/status_macros.hpp"
#include "core/base/status_text.hpp"
#include "fmt/format.h"
#include "segserve/client/result_file.hpp"
#include "segserve/codec/cloud_file.hpp"
#include "segserve/codec/length_unit.hpp"

namespace segserve::segctl {
namespace {

/// INVALID_ARGUMENT if it is plain that the result is of another cloud; a warning if this is not known.
absl::Status check_cloud(const std::string& cloud_name, const std::string& result_name, const SavedResult& saved,
                         const CloudView& cloud, std::vector<codec::Warning>& warnings) {
  if (cloud.size() != saved.result.points) {
    return absl::InvalidArgumentError(fmt::format("{} has {} points, but the saved result has {}: it is another cloud",
                                                  cloud_name, cloud.size(), saved.result.points));
  }
  if (!saved.cloud) {
    warnings.push_back({codec::WarningReason::kOther,
                        fmt::format("{} was saved by an older segctl and does not tell which cloud it belongs to: it "
                                    "is not checked that this is {}",
                                    result_name, cloud_name)});
    return absl::OkStatus();
  }
  const client::CloudFingerprint print = client::fingerprint(cloud);
  if (print.coordinates != saved.cloud->coordinates) {
    return absl::InvalidArgumentError(
        fmt::format("{} is not the cloud that was segmented for {}: it has as many points, but other ones", cloud_name,
                    result_name));
  }
  if (print.colors != saved.cloud->colors) {
    warnings.push_back({codec::WarningReason::kOther,
                        fmt::format("{} has other colors than the cloud that was segmented", cloud_name)});
  }
  return absl::OkStatus();
}

/// Reads the cloud as it was read when it was segmented.
codec::ReadOptions read_options_of(const client::Result& result) {
  return {
      .view = result.view, .unit = codec::length_unit_of(result.placement.meters_per_unit()), .keep_everything = true};
}

}  // namespace

bool is_saved_result(std::string_view bytes) { return bytes.starts_with("segserve-result "); }

absl::StatusOr<SavedResult> decode_saved_result(std::string_view bytes, const std::string& name) {
  auto result = client::decode_result_file(bytes);
  if (!result.ok()) return with_prefix(name, result.status());
  ASSIGN_OR_RETURN(const auto cloud, client::fingerprint_in_result_file(bytes));
  return SavedResult{*std::move(result), cloud};
}

absl::StatusOr<SavedResult> load_saved_result(const std::string& path) {
  ASSIGN_OR_RETURN(const std::string bytes, read_input(path));
  return decode_saved_result(bytes, input_name(path));
}

absl::StatusOr<codec::LabeledCloud> load_segmented_cloud(const std::string& path, const SavedResult& saved,
                                                         const std::string& result_name,
                                                         std::vector<codec::Warning>& warnings) {
  ASSIGN_OR_RETURN(auto scene, codec::load_cloud(path, read_options_of(saved.result)));
  RETURN_IF_ERROR(check_cloud(input_name(path), result_name, saved, scene.cloud, warnings));
  return scene;
}

}  // namespace segserve::segctl
