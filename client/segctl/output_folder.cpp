// SPDX-License-Identifier: Apache-2.0
#include "client/segctl/output_folder.hpp"

#include <filesystem>
#include <system_error>

#include "fmt/format.h"

namespace segserve::segctl {

absl::Status make_folder(const std::string& path) {
  std::error_code error;
  std::filesystem::create_directories(path, error);
  if (std::filesystem::is_directory(path)) return absl::OkStatus();
  return absl::InvalidArgumentError(
      fmt::format("--out-dir: cannot make the folder {}: {}", path, error ? error.message() : "it is a file"));
}

}  // namespace segserve::segctl
