#include "client/segctl/batch_inputs.hpp"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <map>
#include <system_error>

#include "client/segctl/view_flag.hpp"
#include "fmt/format.h"
#include "nlohmann/json.hpp"
#include "proto/wire/options_message.hpp"

namespace segserve::segctl {
namespace {

namespace fs = std::filesystem;

bool is_cloud_file(const fs::directory_entry& entry) {
  std::string extension = entry.path().extension().string();
  std::ranges::transform(extension, extension.begin(), [](unsigned char c) { return std::tolower(c); });
  std::error_code error;
  return entry.is_regular_file(error) && (extension == ".pcd" || extension == ".ply");
}

absl::Status list(const std::string& folder, std::vector<std::string>& files) {
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

absl::StatusOr<std::vector<std::string>> expand(const std::vector<std::string>& paths) {
  std::vector<std::string> files;
  for (const std::string& path : paths) {
    std::error_code error;
    if (path == "-") return absl::InvalidArgumentError("standard input has no name for --out-dir");
    if (fs::is_directory(path, error)) {
      if (absl::Status status = list(path, files); !status.ok()) return status;
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
  const auto files = expand(paths);
  if (!files.ok()) return files.status();
  std::vector<BatchInput> inputs;
  std::map<std::string, std::string> owners;  // of a name in the output folder
  for (const std::string& file : *files) {
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

std::string batch_key(const Options& options, const std::optional<View>& view,
                      const std::optional<wire::CodecOptions>& codec, bool segments) {
  std::string key = fmt::format("{} {}", wire::options_hash(options), view ? view_text(*view) : "as the file says");
  if (codec && !wire::info(codec->codec).is_lossless) {
    key += fmt::format(" {} {} {}", wire::info(codec->codec).name, codec->error_bound, codec->jpeg_quality);
  }
  if (segments) key += " segments";
  return key;
}

bool is_done(const BatchInput& input, const std::string& key) {
  std::error_code error;
  if (!fs::is_regular_file(input.cloud_path, error)) return false;
  std::ifstream file(input.summary_path);
  const auto summary = nlohmann::json::parse(file, nullptr, false);
  if (!summary.is_object()) return false;
  const auto found = summary.find("batch");
  if (found == summary.end() || !found->is_object()) return false;
  return found->value("key", "") == key &&
         found->value("input_bytes", std::uint64_t{0}) == fs::file_size(input.path, error);
}

}  // namespace segserve::segctl
