// SPDX-License-Identifier: Apache-2.0
#include "credentials/watched_file.hpp"

#include <utility>

#include "core/base/regular_file.hpp"

namespace segserve::credentials {

WatchedFile::Content WatchedFile::read() { return in_use_ = last_seen_ = read_regular_file(path_, most_bytes_); }

std::optional<WatchedFile::Content> WatchedFile::changed() {
  const Content before = std::exchange(last_seen_, read_regular_file(path_, most_bytes_));
  if (last_seen_ == in_use_ || last_seen_ != before) return std::nullopt;
  in_use_ = last_seen_;
  return in_use_;
}

}  // namespace segserve::credentials
