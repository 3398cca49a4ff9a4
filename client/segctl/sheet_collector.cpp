// SPDX-License-Identifier: Apache-2.0
#include "client/segctl/sheet_collector.hpp"

#include <algorithm>
#include <filesystem>
#include <utility>

#include "client/segctl/messages.hpp"
#include "fmt/format.h"
#include "segserve/codec/cloud_file.hpp"

namespace segserve::segctl {
namespace {

std::string note_of(const FileOutcome& outcome) {
  switch (outcome.state) {
    case FileOutcome::State::kOpen:
      return "not done";
    case FileOutcome::State::kFailed:
      return "failed";
    default:
      return fmt::format("{} segment{}", outcome.segments, outcome.segments == 1 ? "" : "s");
  }
}

}  // namespace

void SheetCollector::add(std::size_t file, const CloudView& cloud, std::span<const std::uint32_t> labels) {
  if (file >= kMostPictures) return;
  picture::Image image = picture::sheet_picture(cloud, labels);
  const MutexLock lock(mutex_);
  pictures_[file] = std::move(image);
}

void SheetCollector::add_done_before(std::size_t file, const BatchInput& input) {
  const auto labeled = codec::load_cloud(input.cloud_path, {});
  if (labeled.ok() && labeled->label.size() == labeled->cloud.size()) add(file, labeled->cloud, labeled->label);
}

picture::Image SheetCollector::make(const std::vector<BatchInput>& inputs, const std::vector<FileOutcome>& outcomes) {
  const std::size_t drawn = std::min(inputs.size(), kMostPictures);
  for (std::size_t i = 0; i < drawn; ++i) {
    if (outcomes[i].state == FileOutcome::State::kSkipped) add_done_before(i, inputs[i]);
  }
  if (drawn < inputs.size()) {
    print_warning(fmt::format("--contact-sheet: the first {} of {} files are drawn", drawn, inputs.size()));
  }
  const MutexLock lock(mutex_);
  std::vector<picture::SheetEntry> entries;
  for (std::size_t i = 0; i < drawn; ++i) {
    picture::SheetEntry& entry = entries.emplace_back();
    entry.name = std::filesystem::path(inputs[i].path).filename().string();
    entry.note = note_of(outcomes[i]);
    if (const auto picture = pictures_.find(i); picture != pictures_.end()) entry.picture = std::move(picture->second);
  }
  pictures_.clear();
  return picture::make_contact_sheet(entries, fmt::format("{} files", inputs.size()));
}

}  // namespace segserve::segctl
