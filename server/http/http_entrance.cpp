// SPDX-License-Identifier: Apache-2.0
#include "server/http/http_entrance.hpp"

#include <algorithm>
#include <utility>

#include "client/page/bundled_pages.hpp"
#include "core/base/status_macros.hpp"
#include "fmt/format.h"
#include "proto/wire/status_message.hpp"
#include "server/frames/catch_exceptions.hpp"
#include "server/http/connect_call.hpp"
#include "server/http/frame_uploads.hpp"
#include "server/http/http_error.hpp"
#include "server/http/info_upload.hpp"
#include "server/options/host_name.hpp"
#include "server/scheduling/refusals.hpp"

namespace segserve::server {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::string_view kServicePath = "/segserve.v1.SegmentationService/";
constexpr std::string_view kText = "text/plain; charset=utf-8";
constexpr std::string_view kMetricsText = "text/plain; version=0.0.4; charset=utf-8";
constexpr std::string_view kNothingElse = "default-src 'none'; frame-ancestors 'none'";

HttpAnswer text_answer(unsigned status, std::string text, std::string_view type = kText) {
  return {.status = status, .headers = {{"Content-Type", std::string(type)}}, .body = std::move(text)};
}

/// The answer to a request with a method that its path does not allow.
HttpAnswer wrong_method(std::string_view allowed) {
  HttpAnswer answer = text_answer(405, fmt::format("this path takes {} only\n", allowed));
  answer.headers.emplace_back("Allow", std::string(allowed));
  return answer;
}

bool is_get(const HttpHead& head) { return head.method == "GET" || head.method == "HEAD"; }

PresentedProofs proofs_of(const HttpHead& head) {
  PresentedProofs proofs{.certificate_name = head.certificate_name};
  for (const auto& [name, value] : head.headers) {
    if (name == "authorization") proofs.authorizations.emplace_back(value);
  }
  return proofs;
}

Caller caller_of(const HttpHead& head, std::string subject) {
  Caller caller{.peer = head.peer, .subject = std::move(subject), .client_name = "http"};
  const std::string_view traceparent = head.header("traceparent");
  if (traceparent.size() <= kMostTraceparentBytes) caller.traceparent = traceparent;
  return caller;
}

HttpAnswer health_answer(const HealthState& health, std::string_view service) {
  const bool serves = health.status_of(service) == grpc::health::v1::HealthCheckResponse::SERVING;
  return serves ? text_answer(200, "ok\n") : text_answer(503, "not serving\n");
}

HttpAnswer page_answer() {
  if (page::view_page().empty()) {
    return text_answer(404, "this server was built without its page; configure it where npm is installed\n");
  }
  HttpAnswer answer = text_answer(200, page::server_page(), "text/html; charset=utf-8");
  answer.headers.emplace_back("Content-Security-Policy", page::server_page_policy());
  return answer;
}

}  // namespace

HttpEntrance::HttpEntrance(EntranceOptions options, SegmentationService& service, const HealthState& health,
                           Metrics metrics)
    : options_(std::move(options)), service_(service), health_(health), metrics_(std::move(metrics)) {}

UploadPace HttpEntrance::upload_pace() const { return service_.parts().settings.upload_pace_now(); }

std::chrono::milliseconds HttpEntrance::answer_timeout() const {
  return service_.parts().settings.result_timeout_now();
}

HttpEntrance::Begun HttpEntrance::begin(const HttpHead& head) {
  Begun begun = text_answer(500, "");
  const absl::Status status = catch_exceptions("answer a request", [&] {
    begun = route(head);
    return absl::OkStatus();
  });
  if (!status.ok()) begun = text_answer(500, "the server failed; its log says more\n");
  if (auto* answer = std::get_if<HttpAnswer>(&begun)) *answer = dressed(std::move(*answer), head);
  return begun;
}

HttpEntrance::Begun HttpEntrance::route(const HttpHead& head) {
  // Only HTTP/1.0 goes without the header, and no browser speaks that.
  const std::string_view host = head.header("host");
  if (options_.only_known_hosts && !host.empty() && !is_host_allowed(host, options_.host_names)) {
    return text_answer(421, "this server answers to localhost, and to what --http-host names\n");
  }
  if (head.method == "OPTIONS") return HttpAnswer{.status = 204};
  if (head.path == "/v1/segment") return head.method == "POST" ? begin_segment(head) : wrong_method("POST");
  if (head.path.starts_with(kServicePath)) {
    if (head.method != "POST") return wrong_method("POST");
    return begin_connect(head, std::string_view(head.path).substr(kServicePath.size()));
  }
  const bool is_known = head.path == "/" || head.path == "/healthz" || head.path == "/readyz" ||
                        (head.path == "/metrics" && metrics_ != nullptr);
  if (!is_known) return text_answer(404, "there is nothing at this path\n");
  if (!is_get(head)) return wrong_method("GET, HEAD");
  if (head.path == "/healthz") return health_answer(health_, "liveness");
  if (head.path == "/readyz") return health_answer(health_, "readiness");
  return head.path == "/" ? page_answer() : metrics_answer(head);
}

absl::StatusOr<std::shared_ptr<HttpFrame>> HttpEntrance::admit(const HttpHead& head,
                                                               std::optional<std::chrono::milliseconds> timeout) {
  const SegmentationService::Parts parts = service_.parts();
  const auto refuse = [&](const absl::Status& why) {
    const auto now = Clock::now();
    FrameRecord record = arriving_call(caller_of(head, ""), now);
    end_call(record, why, now);
    parts.observers.on_frame(record);
    return why;
  };
  absl::StatusOr<AccessGrant> grant = parts.access.admit(proofs_of(head));
  if (!grant.ok()) return refuse(grant.status());
  if (!parts.calls.admit()) return refuse(draining());
  const auto deadline = timeout ? std::optional(Clock::now() + *timeout) : std::nullopt;
  Caller caller = caller_of(head, grant->subject());
  auto frame = std::make_shared<HttpFrame>(parts, *std::move(grant), std::move(caller), deadline);
  const MutexLock lock(mutex_);
  std::erase_if(frames_, [](const std::weak_ptr<HttpFrame>& kept) { return kept.expired(); });
  frames_.push_back(frame);
  return frame;
}

HttpEntrance::Begun HttpEntrance::begin_segment(const HttpHead& head) {
  const auto form = accepted_form(head.header("accept"));
  if (!form) {
    return text_answer(406, fmt::format("the answer is {}, {} or {}\n", content_type(AnswerForm::kJson),
                                        content_type(AnswerForm::kLabels), content_type(AnswerForm::kView)));
  }
  if (const std::string_view encoding = head.header("content-encoding"); !encoding.empty() && encoding != "identity") {
    return text_answer(415, "a compressed body is not read; a file may be compressed itself, as NAME.gz or NAME.zst\n");
  }
  auto parameters = parse_segment_parameters(head.query, service_.parts().resolver.default_options());
  const auto frame = admit(head, parameters.ok() ? parameters->timeout : std::nullopt);
  if (!frame.ok()) return error_answer(frame.status());
  if (!parameters.ok()) {
    (*frame)->refuse(parameters.status());
    return error_answer(parameters.status());
  }
  (*frame)->record().request_id = parameters->request_id;
  FileRequest request{.parameters = *std::move(parameters),
                      .form = *form,
                      .content_type = std::string(head.header("content-type")),
                      .max_body_bytes = options_.max_body_bytes};
  return file_upload(*frame, std::move(request), service_.parts().resolver,
                     [this, head](HttpAnswer answer) { return dressed(std::move(answer), head); });
}

HttpEntrance::Begun HttpEntrance::begin_connect(const HttpHead& head, std::string_view method) {
  const auto codec = connect_codec(head.header("content-type"));
  if (!codec) {
    HttpAnswer answer =
        connect_error_answer(wire::malformed("the Content-Type must be application/proto or application/json; streams "
                                             "and gRPC itself need the port of gRPC"));
    answer.status = 415;
    answer.headers.emplace_back("Accept-Post", "application/proto, application/json");
    return answer;
  }
  if (method != "Segment" && method != "GetServerInfo") {
    HttpAnswer answer = text_answer(
        501, R"({"code":"unimplemented","message":"unary calls are Segment and GetServerInfo"})", "application/json");
    if (method != "SegmentStream") answer.status = 404;
    return answer;
  }
  const auto timeout = connect_timeout(head);
  if (!timeout.ok()) return connect_error_answer(timeout.status());
  if (method == "GetServerInfo") {
    const absl::Status admitted = admit_question(head, "GetServerInfo");
    if (!admitted.ok()) return connect_error_answer(admitted);
    return info_upload(*codec, service_.parts().info,
                       [this, head](HttpAnswer answer) { return dressed(std::move(answer), head); });
  }
  const auto frame = admit(head, *timeout);
  if (!frame.ok()) return connect_error_answer(frame.status());
  return connect_upload(*frame, *codec, service_.parts().resolver,
                        [this, head](HttpAnswer answer) { return dressed(std::move(answer), head); });
}

absl::Status HttpEntrance::admit_question(const HttpHead& head, std::string_view rpc) {
  const SegmentationService::Parts parts = service_.parts();
  absl::Status admitted = parts.access.admit(proofs_of(head)).status();
  if (!admitted.ok()) {
    parts.observers.on_refused_question(
        {.rpc = rpc, .caller = std::make_shared<const Caller>(caller_of(head, "")), .status = facts_of(admitted)});
  }
  return admitted;
}

HttpAnswer HttpEntrance::metrics_answer(const HttpHead& head) {
  if (const absl::Status admitted = admit_question(head, "metrics"); !admitted.ok()) return error_answer(admitted);
  auto text = metrics_();
  if (!text) return text_answer(429, "too many were asked for\n");
  return text_answer(200, *std::move(text), kMetricsText);
}

HttpAnswer HttpEntrance::dressed(HttpAnswer answer, const HttpHead& head) const {
  HttpHeaders& headers = answer.headers;
  const bool has_policy =
      std::ranges::any_of(headers, [](const auto& header) { return header.first == "Content-Security-Policy"; });
  if (!has_policy) headers.emplace_back("Content-Security-Policy", kNothingElse);
  headers.emplace_back("X-Content-Type-Options", "nosniff");
  headers.emplace_back("X-Frame-Options", "DENY");
  headers.emplace_back("Referrer-Policy", "no-referrer");
  headers.emplace_back("Cross-Origin-Opener-Policy", "same-origin");
  headers.emplace_back("Cache-Control", "no-store");
  const std::string_view origin = head.header("origin");
  const bool allows_all = options_.allow_origin == "*";
  headers.emplace_back("Cross-Origin-Resource-Policy", options_.allow_origin.empty() ? "same-origin" : "cross-origin");
  if (!options_.allow_origin.empty() && !allows_all) headers.emplace_back("Vary", "Origin");
  if (origin.empty() || (origin != options_.allow_origin && !allows_all)) return answer;
  headers.emplace_back("Access-Control-Allow-Origin", options_.allow_origin);
  headers.emplace_back(
      "Access-Control-Expose-Headers",
      "Retry-After, Segserve-Array, Segserve-Points, Segserve-Width, Segserve-Height, Segserve-Segments");
  if (head.method == "OPTIONS") {
    headers.emplace_back("Access-Control-Allow-Methods", "GET, POST");
    headers.emplace_back(
        "Access-Control-Allow-Headers",
        "Accept, Authorization, Connect-Protocol-Version, Connect-Timeout-Ms, Content-Type, Traceparent");
    headers.emplace_back("Access-Control-Max-Age", "7200");
  }
  return answer;
}

void HttpEntrance::abort_frames() {
  std::vector<std::weak_ptr<HttpFrame>> frames;
  {
    const MutexLock lock(mutex_);
    frames = frames_;
  }
  for (const auto& each : frames) {
    if (const std::shared_ptr<HttpFrame> frame = each.lock()) frame->abort();
  }
}

}  // namespace segserve::server
