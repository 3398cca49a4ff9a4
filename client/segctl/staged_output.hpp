// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "absl/status/status.h"

namespace segserve::segctl {

/// The output files of one command. Their contents are kept in memory until everything is computed, then written under
/// temporary names and renamed, so that a failure never leaves a partial file, or some of the files, behind.
class StagedOutput {
 public:
  /// Announces a file ("-": standard output) before the work starts. INVALID_ARGUMENT if its folder does not exist, if
  /// it is a folder, or if the same target was announced already.
  absl::Status announce(std::string_view path) { return announce(path, false); }
  /// Announces the labeled cloud, which holds all that its input holds, so that it may take the input's place.
  absl::Status announce_labeled_cloud(std::string_view path) { return announce(path, true); }

  /// Names files that the command reads. INVALID_ARGUMENT if an output that was announced, or will be, would replace
  /// one of them, by whatever name: announce() then says so. Only the labeled cloud may, if `by_labeled_cloud` is
  /// false.
  absl::Status protect(const std::vector<std::string>& inputs, bool by_labeled_cloud = false);

  /// Announces a folder for files, which commit() makes if it is missing, and removes again if it fails.
  /// INVALID_ARGUMENT if there is a file of this name.
  absl::Status announce_folder(const std::string& path);

  /// Writes a whole file to the path that it is given, or to standard output for "-".
  using Writer = std::function<absl::Status(const std::string& path)>;

  /// Adds the content of an announced file.
  void add(std::string_view path, std::string bytes);
  void add(std::string_view path, Writer writer);

  /// Has commit() remove an old file once everything was written.
  void remove(std::string path) { removed_.push_back(std::move(path)); }

  /// True if one of the announced files goes to standard output.
  bool uses_stdout() const;

  /// Writes everything that was added: first the files, then standard output. Files are renamed in the opposite order
  /// of add.
  absl::Status commit();

 private:
  struct File {
    std::string path;
    Writer write;
  };
  struct Announced {
    std::string target;  ///< "-", or where symbolic links lead
    bool is_labeled_cloud = false;
  };
  struct Input {
    std::string path;
    bool by_labeled_cloud = false;  ///< it is protected from the labeled cloud, too
  };

  absl::Status announce(std::string_view path, bool is_labeled_cloud);
  static absl::Status check_replacement(const Announced& output, const Input& input);

  std::vector<Announced> announced_;
  std::vector<Input> inputs_;
  std::vector<std::string> folders_;
  std::vector<File> files_;
  std::vector<std::string> removed_;
};

}  // namespace segserve::segctl
