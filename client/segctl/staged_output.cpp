// SPDX-License-Identifier: Apache-2.0
#include "client/segctl/staged_output.hpp"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <system_error>
#include <utility>

#include "core/base/status_macros.hpp"
#include "fmt/format.h"

namespace segserve::segctl {
namespace {

namespace fs = std::filesystem;

absl::Status cannot_write(std::string_view path, int error) {
  return absl::UnavailableError(fmt::format("cannot write {}: {}", path, std::strerror(error)));
}

absl::Status write_bytes(const std::string& path, std::string_view bytes) {
  const bool to_stdout = path == "-";
  std::FILE* file = to_stdout ? stdout : std::fopen(path.c_str(), "wb");
  if (file == nullptr) return cannot_write(path, errno);
  const bool written = std::fwrite(bytes.data(), 1, bytes.size(), file) == bytes.size();
  const int write_error = errno;
  const bool closed = (to_stdout ? std::fflush(file) : std::fclose(file)) == 0;  // A full disk may show only here.
  if (written && closed) return absl::OkStatus();
  return cannot_write(to_stdout ? "standard output" : path, written ? errno : write_error);
}

/// True for regular files and new ones. Devices and pipes are written to, not replaced.
bool is_replaceable(const fs::path& path) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  return status.type() == fs::file_type::not_found || status.type() == fs::file_type::regular;
}

/// The file that a symbolic link leads to, so that the link itself survives.
fs::path target_of(const fs::path& path) {
  std::error_code error;
  fs::path target = fs::weakly_canonical(path, error);
  return error ? path : target;
}

/// Folders that are made. The destructor removes them again if they are not to be kept and are empty.
class NewFolders {
 public:
  NewFolders() = default;
  NewFolders(const NewFolders&) = delete;
  NewFolders& operator=(const NewFolders&) = delete;
  ~NewFolders() {
    std::error_code ignored;
    for (auto folder = made_.rbegin(); folder != made_.rend(); ++folder) fs::remove(*folder, ignored);
  }

  absl::Status make(const fs::path& folder) {
    std::error_code error;
    if (folder.empty() || fs::is_directory(folder, error)) return absl::OkStatus();
    RETURN_IF_ERROR(make(folder.parent_path()));
    if (!fs::create_directory(folder, error) && error) {
      return absl::UnavailableError(fmt::format("cannot make the folder {}: {}", folder.string(), error.message()));
    }
    made_.push_back(folder);
    return absl::OkStatus();
  }

  void keep() { made_.clear(); }

 private:
  std::vector<fs::path> made_;  ///< The outer ones first.
};

/// Temporary files. The destructor removes those that were not renamed.
class TemporaryFiles {
 public:
  TemporaryFiles() = default;
  TemporaryFiles(const TemporaryFiles&) = delete;
  TemporaryFiles& operator=(const TemporaryFiles&) = delete;
  ~TemporaryFiles() {
    std::error_code ignored;
    for (const auto& [temporary, target] : files_) fs::remove(temporary, ignored);
  }

  absl::Status write(const fs::path& target, const StagedOutput::Writer& writer) {
    fs::path temporary = target;
    temporary += fmt::format(".tmp-{}-{}", getpid(), files_.size());
    files_.emplace_back(temporary, target);
    return writer(temporary.string());
  }

  absl::Status rename_all() {
    while (!files_.empty()) {
      std::error_code error;
      fs::rename(files_.back().first, files_.back().second, error);
      if (error) return cannot_write(files_.back().second.native(), error.value());
      files_.pop_back();
    }
    return absl::OkStatus();
  }

 private:
  std::vector<std::pair<fs::path, fs::path>> files_;  ///< Temporary name and final name.
};

}  // namespace

absl::Status StagedOutput::protect(const std::vector<std::string>& inputs, bool by_labeled_cloud) {
  for (const std::string& path : inputs) {
    if (path == "-") continue;
    inputs_.push_back({path, by_labeled_cloud});
    for (const Announced& output : announced_) RETURN_IF_ERROR(check_replacement(output, inputs_.back()));
  }
  return absl::OkStatus();
}

absl::Status StagedOutput::announce(std::string_view path, bool is_labeled_cloud) {
  std::string target = path == "-" ? "-" : target_of(fs::path(path)).string();
  if (path != "-") {
    const fs::path parent = fs::path(target).parent_path();
    std::error_code error;
    if (!parent.empty() && !fs::is_directory(parent, error)) {
      return absl::InvalidArgumentError(fmt::format("cannot write {}: there is no folder {}", path, parent.string()));
    }
    if (path.empty() || fs::is_directory(target, error)) {
      return absl::InvalidArgumentError(fmt::format("cannot write '{}': it is not the name of a file", path));
    }
  }
  const bool is_announced = std::ranges::find(announced_, target, &Announced::target) != announced_.end();
  if (is_announced && (path == "-" || is_replaceable(target))) {
    return absl::InvalidArgumentError(
        fmt::format("two outputs cannot both go to {}", path == "-" ? "standard output" : path));
  }
  announced_.push_back({std::move(target), is_labeled_cloud});
  for (const Input& input : inputs_) RETURN_IF_ERROR(check_replacement(announced_.back(), input));
  return absl::OkStatus();
}

absl::Status StagedOutput::announce_folder(const std::string& path) {
  std::error_code error;
  fs::path above(path);
  while (!above.empty() && !fs::exists(above, error)) above = above.parent_path();
  if (!above.empty() && !fs::is_directory(above, error)) {
    return absl::InvalidArgumentError(fmt::format("cannot make the folder {}: {} is a file", path, above.string()));
  }
  folders_.push_back(path);
  return absl::OkStatus();
}

void StagedOutput::add(std::string_view path, std::string bytes) {
  add(path, [content = std::move(bytes)](const std::string& target) { return write_bytes(target, content); });
}

void StagedOutput::add(std::string_view path, Writer writer) {
  files_.push_back({std::string(path), std::move(writer)});
}

bool StagedOutput::uses_stdout() const {
  return std::ranges::find(announced_, "-", &Announced::target) != announced_.end();
}

absl::Status StagedOutput::check_replacement(const Announced& output, const Input& input) {
  if (output.target == "-" || (output.is_labeled_cloud && !input.by_labeled_cloud)) return absl::OkStatus();
  std::error_code error;
  if (!fs::equivalent(output.target, input.path, error) || !is_replaceable(output.target)) return absl::OkStatus();
  return absl::InvalidArgumentError(
      fmt::format("{} would be overwritten by an output: choose another name for it", input.path));
}

absl::Status StagedOutput::commit() {
  NewFolders folders;
  for (const std::string& folder : folders_) RETURN_IF_ERROR(folders.make(folder));
  TemporaryFiles temporary;
  for (const File& file : files_) {
    if (file.path == "-") continue;
    const bool replace = is_replaceable(file.path);
    RETURN_IF_ERROR(replace ? temporary.write(target_of(file.path), file.write) : file.write(file.path));
  }
  RETURN_IF_ERROR(temporary.rename_all());
  folders.keep();
  for (const std::string& path : removed_) {
    std::error_code error;
    if (!fs::remove(path, error) && error) return cannot_write(path, error.value());
  }
  for (const File& file : files_) {
    if (file.path == "-") RETURN_IF_ERROR(file.write("-"));
  }
  return absl::OkStatus();
}

}  // namespace segserve::segctl
