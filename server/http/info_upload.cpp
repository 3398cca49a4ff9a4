// SPDX-License-Identifier: Apache-2.0
#include "server/http/info_upload.hpp"

#include <string>
#include <utility>

#include "core/base/status_macros.hpp"
#include "proto/wire/status_message.hpp"
#include "server/frames/catch_exceptions.hpp"
#include "server/http/http_error.hpp"

namespace segserve::server {
namespace {

/// The body is so small that it needs no lease of memory.
class InfoUpload final : public HttpUpload {
 public:
  InfoUpload(ConnectCodec codec, const v1::GetServerInfoResponse& info, DressAnswer dress)
      : codec_(codec), info_(info), dress_(std::move(dress)) {}

  std::uint64_t most_bytes() const override { return std::uint64_t{64} << 10U; }
  std::optional<HttpAnswer> announce(std::uint64_t bytes) override { return reserve(bytes); }
  std::optional<HttpAnswer> reserve(std::uint64_t bytes) override {
    if (bytes <= most_bytes()) return std::nullopt;
    return refused(wire::limit_exceeded("the request", bytes, "bytes", "max_message_bytes", most_bytes()));
  }
  HttpAnswer stalled() override {
    return refused(absl::DeadlineExceededError("the body of the request came too slowly"));
  }
  HttpAnswer broken(std::string_view why) override { return refused(wire::malformed(why)); }
  void finish(std::string body, Done done) override {
    auto answer = catch_exceptions("answer GetServerInfo", [&] { return answer_to(std::move(body)); });
    done(answer.ok() ? dress_(*std::move(answer)) : refused(answer.status()));
  }
  void cancel() override {}
  void on_tick(Time /*now*/) override {}

 private:
  HttpAnswer refused(const absl::Status& status) const { return dress_(connect_error_answer(status)); }

  absl::StatusOr<HttpAnswer> answer_to(std::string body) const {
    v1::GetServerInfoRequest request;
    RETURN_IF_ERROR(parse_connect(codec_, std::move(body), "GetServerInfoRequest", request));
    return connect_answer(codec_, info_);
  }

  const ConnectCodec codec_;
  const v1::GetServerInfoResponse& info_;
  const DressAnswer dress_;
};

}  // namespace

std::shared_ptr<HttpUpload> info_upload(ConnectCodec codec, const v1::GetServerInfoResponse& info, DressAnswer dress) {
  return std::make_shared<InfoUpload>(codec, info, std::move(dress));
}

}  // namespace segserve::server
