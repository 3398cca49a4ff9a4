#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"

namespace segserve::segctl {

/// The output files of one command: kept in memory until everything is computed, then written under
/// temporary names and renamed, so that a failure never leaves a partial or a lone file behind.
class StagedOutput {
 public:
  /// Announces a file ("-": standard output) before the work starts. INVALID_ARGUMENT if its folder
  /// does not exist, it is a folder, or the same target was announced already.
  absl::Status announce(std::string_view path);

  /// Writes a whole file to a path it is given, or to standard output for "-".
  using Writer = std::function<absl::Status(const std::string& path)>;

  /// The content of an announced file.
  void add(std::string_view path, std::string bytes);
  void add(std::string_view path, Writer writer);

  /// True if some announced file goes to standard output.
  bool uses_stdout() const;

  /// Writes all that was added: first the files, then standard output.
  absl::Status commit();

 private:
  struct File {
    std::string path;
    Writer write;
  };
  std::vector<std::string> announced_;
  std::vector<File> files_;
};

}  // namespace segserve::segctl
