// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "absl/base/thread_annotations.h"
#include "absl/status/statusor.h"
#include "client/load_test/http_listener.hpp"
#include "client/segctl/agent_address.hpp"
#include "core/base/mutex.hpp"
#include "nlohmann/json.hpp"
#include "segserve/client/frame.hpp"
#include "segserve/codec/labeled_cloud.hpp"

namespace segserve::segctl {

/// The newest frame of a stream, which browsers are shown.
struct LiveFrame {
  std::string title;
  std::shared_ptr<const codec::LabeledCloud> cloud;
  client::Result result;  ///< with labels, supervoxels and tree
  nlohmann::ordered_json stats;
};

/// The page of a stream: GET / is the page, and GET /live?after=N waits until there is a newer frame than N and answers
/// it. Only the newest frame is kept, and it is written out once for all browsers, when one asks, so that a slow
/// browser gets fewer frames and delays nobody.
class LivePage {
 public:
  /// INVALID_ARGUMENT if this program has no page; UNAVAILABLE if the address cannot be bound.
  static absl::StatusOr<std::unique_ptr<LivePage>> start(const AgentAddress& address);
  ~LivePage();
  LivePage(const LivePage&) = delete;
  LivePage& operator=(const LivePage&) = delete;

  int port() const { return listener_->port(); }
  /// Replaces the frame that is shown. From any thread.
  void show(LiveFrame frame) ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  using Text = std::shared_ptr<const std::string>;

  explicit LivePage(std::string page);
  bench::HttpReply answer(const bench::HttpRequest& request) ABSL_LOCKS_EXCLUDED(mutex_, writing_);
  bench::HttpReply answer_live(std::uint64_t after) ABSL_LOCKS_EXCLUDED(mutex_, writing_);
  /// The newest frame as JSON.
  Text written() ABSL_LOCKS_EXCLUDED(mutex_, writing_);

  const Text page_;
  Mutex mutex_;
  CondVar changed_;
  std::shared_ptr<const LiveFrame> newest_ ABSL_GUARDED_BY(mutex_);
  std::uint64_t sequence_ ABSL_GUARDED_BY(mutex_) = 0;  // of the newest frame, from 1
  bool is_closed_ ABSL_GUARDED_BY(mutex_) = false;
  Mutex writing_;  // one browser writes, and the others wait for the same text
  std::uint64_t written_sequence_ ABSL_GUARDED_BY(writing_) = 0;
  Text written_ ABSL_GUARDED_BY(writing_);
  std::unique_ptr<bench::HttpListener> listener_;
};

}  // namespace segserve::segctl
