// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "client/segctl/batch_inputs.hpp"
#include "client/segctl/batch_progress.hpp"
#include "core/base/mutex.hpp"
#include "core/lab/picture/contact_sheet.hpp"
#include "segserve/cloud.hpp"

namespace segserve::segctl {

/// Collects small pictures of the files of a batch while they are segmented. Thread-safe.
class SheetCollector {
 public:
  /// Only the first files are drawn, so that the sheet does not outgrow the memory.
  static constexpr std::size_t kMostPictures = 1000;

  /// Draws a file, given by its index.
  void add(std::size_t file, const CloudView& cloud, std::span<const std::uint32_t> labels) ABSL_LOCKS_EXCLUDED(mutex_);

  /// The sheet of the whole batch. The labeled clouds of files that were done before are read and drawn now.
  picture::Image make(const std::vector<BatchInput>& inputs, const std::vector<FileOutcome>& outcomes)
      ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  void add_done_before(std::size_t file, const BatchInput& input);

  Mutex mutex_;
  std::map<std::size_t, picture::Image> pictures_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace segserve::segctl
