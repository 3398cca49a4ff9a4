// SPDX-License-Identifier: Apache-2.0
#include "client/segctl/output_names.hpp"

#include <algorithm>
#include <cctype>
#include <cstddef>
#include <filesystem>
#include <iterator>
#include <map>

namespace segserve::segctl {
namespace {

namespace fs = std::filesystem;

/// A file and how much of its path its name tells: nothing but the stem (0), the extension, too (1), and then one
/// folder more with each step.
struct NamedFile {
  fs::path path;  ///< Absolute, without "." and "..".
  std::size_t detail = 0;

  std::size_t most_detail() const {
    const fs::path folders = path.relative_path().parent_path();
    return 1 + static_cast<std::size_t>(std::distance(folders.begin(), folders.end()));
  }

  std::string name() const {
    std::string extension = path.extension().string();
    std::ranges::transform(extension, extension.begin(), [](unsigned char c) { return std::tolower(c); });
    fs::path name = detail == 0 || extension == ".pcd" ? path.stem() : path.filename();
    fs::path folder = path.relative_path().parent_path();
    for (std::size_t i = 1; i < detail; ++i, folder = folder.parent_path()) name = folder.filename() / name;
    return name.string();
  }
};

}  // namespace

std::vector<std::string> output_names(const std::vector<std::string>& files) {
  std::vector<NamedFile> named;
  for (const std::string& file : files) named.push_back({fs::absolute(file).lexically_normal()});
  for (bool changed = true; changed;) {
    changed = false;
    std::map<std::string, std::vector<NamedFile*>> by_name;
    for (NamedFile& file : named) by_name[file.name()].push_back(&file);
    for (const auto& [name, same] : by_name) {
      if (same.size() == 1) continue;
      for (NamedFile* file : same) {
        if (file->detail == file->most_detail()) continue;
        ++file->detail;
        changed = true;
      }
    }
  }
  std::vector<std::string> names;
  for (const NamedFile& file : named) names.push_back(file.name());
  return names;
}

}  // namespace segserve::segctl
