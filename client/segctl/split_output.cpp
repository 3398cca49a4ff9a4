// SPDX-License-Identifier: Apache-2.0
#include "client/segctl/split_output.hpp"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cstddef>
#include <filesystem>
#include <string_view>
#include <system_error>
#include <vector>

#include "client/segctl/point_subset.hpp"
#include "fmt/format.h"

namespace segserve::segctl {
namespace {

namespace fs = std::filesystem;

constexpr std::uint32_t kMostFiles = 10'000;
constexpr std::string_view kPrefix = "segment_", kSuffix = ".pcd";

std::string file_name(std::uint32_t segment) { return fmt::format("{}{:04}{}", kPrefix, segment, kSuffix); }

/// The number in the name of a file that file_name() made; 0 for any other name.
std::uint32_t segment_of(const std::string& name) {
  if (!name.starts_with(kPrefix) || !name.ends_with(kSuffix)) return 0;
  std::uint32_t segment = 0;
  std::from_chars(name.data() + kPrefix.size(), name.data() + name.size() - kSuffix.size(), segment);
  return file_name(segment) == name ? segment : 0;
}

/// The indices of the points of each segment: those of label i + 1 at i.
std::vector<std::vector<std::size_t>> points_of_segments(std::span<const std::uint32_t> labels,
                                                         std::uint32_t segments) {
  std::vector<std::vector<std::size_t>> points(segments);
  for (std::size_t i = 0; i < labels.size(); ++i) {
    if (labels[i] > 0) points[labels[i] - 1].push_back(i);
  }
  return points;
}

}  // namespace

void SplitOutput::add_to(CLI::App& app) {
  app.add_option("--split", folder_, "write each segment as DIR/segment_0001.pcd and so on, the largest first")
      ->type_name("DIR")
      ->group("Output");
}

absl::Status SplitOutput::announce(StagedOutput& output) const {
  return wanted() ? output.announce_folder(folder_) : absl::OkStatus();
}

absl::Status SplitOutput::add(StagedOutput& output, const codec::LabeledCloud& scene,
                              std::span<const std::uint32_t> labels, const SceneOutput& format,
                              std::vector<codec::Warning>& warnings) const {
  if (!wanted()) return absl::OkStatus();
  const std::uint32_t segments = labels.empty() ? 0 : *std::ranges::max_element(labels);
  if (segments > kMostFiles) {
    return absl::InvalidArgumentError(fmt::format(
        "--split writes at most {} files, but there are {} segments: use a higher --threshold or fewer --regions",
        kMostFiles, segments));
  }
  const auto points = points_of_segments(labels, segments);
  for (std::uint32_t segment = 1; segment <= segments; ++segment) {
    const codec::LabeledCloud part = subset_of(scene, points[segment - 1]);
    const std::vector<std::uint32_t> label(part.cloud.size(), segment);
    codec::EncodedFile file = format.encode_pcd(part, label);
    if (segment == 1) append_warnings(folder_, file.warnings, warnings);  // It is the same for all of them.
    output.add((fs::path(folder_) / file_name(segment)).string(), std::move(file.bytes));
  }
  std::error_code error;
  for (fs::directory_iterator entry(folder_, error), end; !error && entry != end; entry.increment(error)) {
    if (segment_of(entry->path().filename().string()) > segments) output.remove(entry->path().string());
  }
  return absl::OkStatus();
}

}  // namespace segserve::segctl
