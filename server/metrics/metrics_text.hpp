// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "core/base/mutex.hpp"
#include "prometheus/collectable.h"

namespace segserve::server {

/// All metrics as text, wherever they are asked for. Thread-safe.
class MetricsText {
 public:
  using Sources = std::vector<std::shared_ptr<prometheus::Collectable>>;

  explicit MetricsText(Sources sources) : sources_(std::move(sources)) {}

  /// The text; nullopt if it was asked for more than 50 times in a second.
  std::optional<std::string> text();

 private:
  const Sources sources_;
  Mutex mutex_;
  std::chrono::steady_clock::time_point second_began_ ABSL_GUARDED_BY(mutex_){};
  int in_second_ ABSL_GUARDED_BY(mutex_) = 0;
};

}  // namespace segserve::server
