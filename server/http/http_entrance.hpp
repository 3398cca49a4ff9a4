// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "core/base/mutex.hpp"
#include "server/health/health_state.hpp"
#include "server/http/http_frame.hpp"
#include "server/http/http_handler.hpp"
#include "server/rpc/segmentation_service.hpp"

namespace segserve::server {

/// The options of a server's web entrance.
struct EntranceOptions {
  std::uint64_t max_body_bytes = 0;  ///< of POST /v1/segment
  std::string allow_origin = {};     ///< of other sites whose pages may call; "*" for all; empty: none
  /// Whether requests must name this machine, or one of `host_names`, in their header Host.
  bool only_known_hosts = false;
  std::vector<std::string> host_names = {};
};

/// The web entrance of the service: what each path of HTTP does.
///
/// - POST /v1/segment: the bytes of a file, or a form with the images of an RGB-D camera; see segment_parameters.hpp
/// and
///   frame_answer.hpp
/// - POST /segserve.v1.SegmentationService/Segment and /GetServerInfo: the protocol Connect
/// - GET /healthz, /readyz: "liveness" and "readiness" as grpc.health.v1 has them
/// - GET /metrics, if the server has metrics
/// - GET /: the page
///
/// No path leads to a file. Pages, health and preflights need no token; everything else is checked as calls of gRPC
/// are.
class HttpEntrance final : public HttpHandler {
 public:
  /// The text of all metrics, or nullopt if too many were asked for lately.
  using Metrics = std::function<std::optional<std::string>()>;

  /// `service` and `health` must outlive all uploads. `metrics` may be null.
  HttpEntrance(EntranceOptions options, SegmentationService& service, const HealthState& health, Metrics metrics);

  std::variant<HttpAnswer, std::shared_ptr<HttpUpload>> begin(const HttpHead& head) override;
  UploadPace upload_pace() const override;
  std::chrono::milliseconds answer_timeout() const override;

  /// The server closes: all frames end with UNAVAILABLE, DRAINING as soon as nothing is computed for them any more.
  void abort_frames();

 private:
  using Begun = std::variant<HttpAnswer, std::shared_ptr<HttpUpload>>;

  Begun route(const HttpHead& head);
  Begun begin_connect(const HttpHead& head, std::string_view method);
  Begun begin_segment(const HttpHead& head);
  /// Whether the caller may ask about the server; UNAUTHENTICATED otherwise, which the observers learn.
  absl::Status admit_question(const HttpHead& head, std::string_view rpc);
  HttpAnswer metrics_answer(const HttpHead& head);
  /// Adds what every answer has.
  HttpAnswer dressed(HttpAnswer answer, const HttpHead& head) const;
  /// A frame that the service has admitted; an error if the caller may not call.
  absl::StatusOr<std::shared_ptr<HttpFrame>> admit(const HttpHead& head,
                                                   std::optional<std::chrono::milliseconds> timeout);

  const EntranceOptions options_;
  SegmentationService& service_;
  const HealthState& health_;
  const Metrics metrics_;
  Mutex mutex_;
  std::vector<std::weak_ptr<HttpFrame>> frames_ ABSL_GUARDED_BY(mutex_);  // some may be gone
};

}  // namespace segserve::server
