// SPDX-License-Identifier: Apache-2.0
#include "client/segctl/batch_inputs.hpp"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <map>
#include <system_error>

#include "core/base/status_macros.hpp"
#include "fmt/format.h"
#include "nlohmann/json.hpp"

namespace segserve::segctl {
namespace {

namespace fs = std::filesystem;

bool is_cloud_file(const fs::directory_entry& entry) {
  std::string extension = entry.path().extension().string();
  std::ranges::transform(extension, extension.begin(), [](unsigned char c) { return std::tolower(c); });
  std::error_code error;
  return entry.is_regular_file(error) && (extension == ".pcd" || extension == ".ply");
}

absl::Status append_cloud_files(const std::string& folder, std::vector<std::string>& files) {
  std::error_code error;
  std::vector<std::string> found;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
    if (is_cloud_file(*entry)) found.push_back(entry->path().string());
  }
  if (error) return absl::UnavailableError(fmt::format("cannot read folder {}: {}", folder, error.message()));
  std::ranges::sort(found);
  files.insert(files.end(), found.begin(), found.end());
  return absl::OkStatus();
}

absl::StatusOr<std::vector<std::string>> expand_folders(const std::vector<std::string>& paths) {
  std::vector<std::string> files;
  for (const std::string& path : paths) {
    std::error_code error;
    if (path == "-") return absl::InvalidArgumentError("standard input has no name for --out-dir");
    if (fs::is_directory(path, error)) {
      RETURN_IF_ERROR(append_cloud_files(path, files));
    } else if (fs::exists(path, error)) {
      files.push_back(path);
    } else {
      return absl::NotFoundError(fmt::format("there is no {}", path));
    }
  }
  if (files.empty()) return absl::InvalidArgumentError("there is no PCD or PLY file in what was given");
  return files;
}

}  // namespace

absl::StatusOr<std::vector<BatchInput>> batch_inputs(const std::vector<std::string>& paths,
                                                     const std::string& out_dir) {
  ASSIGN_OR_RETURN(const auto files, expand_folders(paths));
  std::vector<BatchInput> inputs;
  std::map<std::string, std::string> owners;  // from a name in the output folder to the file that is written there
  for (const std::string& file : files) {
    const std::string name = fs::path(file).stem().string();
    const auto [owner, is_new] = owners.emplace(name, file);
    if (!is_new) {
      return absl::InvalidArgumentError(fmt::format("{} and {} would both be written to {}.pcd", owner->second, file,
                                                    (fs::path(out_dir) / name).string()));
    }
    const std::string stem = (fs::path(out_dir) / name).string();
    inputs.push_back({file, stem + ".pcd", stem + ".json"});
    std::error_code error;
    if (fs::equivalent(file, inputs.back().cloud_path, error)) {
      return absl::InvalidArgumentError(fmt::format("{} would be overwritten by its own output", file));
    }
  }
  return inputs;
}

std::optional<DoneBefore> done_before(const BatchInput& input, const std::string& key) {
  std::error_code error;
  if (!fs::is_regular_file(input.cloud_path, error)) return std::nullopt;
  std::ifstream file(input.summary_path);
  const auto summary = nlohmann::json::parse(file, nullptr, false);
  if (!summary.is_object()) return std::nullopt;
  const auto batch = summary.find("batch");
  if (batch == summary.end() || !batch->is_object()) return std::nullopt;
  const bool is_same = batch->value("key", "") == key &&
                       batch->value("input_bytes", std::uint64_t{0}) == fs::file_size(input.path, error);
  if (!is_same) return std::nullopt;
  return DoneBefore{summary.value("points", std::size_t{0}), summary.value("segments", std::uint32_t{0})};
}

}  // namespace segserve::segctl
