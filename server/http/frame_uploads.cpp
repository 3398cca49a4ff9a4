// SPDX-License-Identifier: Apache-2.0
#include "server/http/frame_uploads.hpp"

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "core/base/status_macros.hpp"
#include "core/base/status_text.hpp"
#include "fmt/format.h"
#include "proto/wire/codec_message.hpp"
#include "proto/wire/payload/payload_support.hpp"
#include "proto/wire/result_message.hpp"
#include "proto/wire/status_message.hpp"
#include "proto/wire/transport_limits.hpp"
#include "segserve/codec/cloud_file.hpp"
#include "segserve/codec/rgbd.hpp"
#include "server/frames/catch_exceptions.hpp"
#include "server/http/http_error.hpp"
#include "server/http/multipart.hpp"

namespace segserve::server {
namespace {

using Clock = std::chrono::steady_clock;
using AnswerError = HttpAnswer (*)(const absl::Status&);

constexpr std::string_view kForm = "multipart/form-data";

double milliseconds(Clock::duration duration) { return std::chrono::duration<double, std::milli>(duration).count(); }

/// The base of both uploads: it does everything but give the body a meaning.
class FrameUpload : public HttpUpload {
 public:
  FrameUpload(std::shared_ptr<HttpFrame> frame, AnswerError answer_error, DressAnswer dress)
      : frame_(std::move(frame)), answer_error_(answer_error), dress_(std::move(dress)) {}

  std::optional<HttpAnswer> announce(std::uint64_t bytes) final {
    const absl::Status status = catch_exceptions("take a request", [&] { return check_bytes(bytes); });
    if (status.ok()) return std::nullopt;
    return refused(status);
  }

  std::optional<HttpAnswer> reserve(std::uint64_t bytes) final {
    const absl::Status status = catch_exceptions("take a request", [&]() -> absl::Status {
      RETURN_IF_ERROR(check_bytes(bytes));
      return frame_->reserve(memory_of(bytes));
    });
    if (status.ok()) return std::nullopt;
    return refused(status);
  }

  HttpAnswer stalled() final {
    return refused(wire::with_details(absl::DeadlineExceededError("the body of the request came too slowly"),
                                      {.reason = wire::ErrorReason::kUploadStalled}));
  }

  HttpAnswer broken(std::string_view why) final { return refused(wire::malformed(why)); }

  void finish(std::string body, Done done) final {
    const std::uint64_t bytes = body.size();
    auto order = catch_exceptions("read a request", [&] { return read(std::move(body)); });
    if (!order.ok()) return done(refused(order.status()));
    frame_->submit(*std::move(order), bytes,
                   [dress = dress_, answer_error = answer_error_, done = std::move(done)](auto answer) {
                     HttpAnswer last{.status = 500};
                     const absl::Status told = catch_exceptions("answer a request", [&] {
                       last = dress(answer.ok() ? *std::move(answer) : answer_error(answer.status()));
                       return absl::OkStatus();
                     });
                     told.IgnoreError();  // it is in the log
                     done(std::move(last));
                   });
  }

  void cancel() final { frame_->cancel(); }
  void on_tick(Time now) final { frame_->on_tick(now); }

 protected:
  /// The name of most_bytes() in errors, and what has these bytes.
  struct Limit {
    std::string_view name, subject;
  };
  virtual Limit limit() const = 0;
  /// The bytes of memory for a body of so many bytes.
  virtual std::uint64_t memory_of(std::uint64_t bytes) const { return bytes; }
  virtual absl::StatusOr<HttpFrame::Order> read(std::string body) = 0;
  HttpFrame& frame() { return *frame_; }

 private:
  absl::Status check_bytes(std::uint64_t bytes) const {
    if (bytes <= most_bytes()) return absl::OkStatus();
    return wire::limit_exceeded(limit().subject, bytes, "bytes", limit().name, most_bytes());
  }

  HttpAnswer refused(const absl::Status& status) {
    frame_->refuse(status);
    return dress_(answer_error_(status));
  }

  const std::shared_ptr<HttpFrame> frame_;
  const AnswerError answer_error_;
  const DressAnswer dress_;
};

/// The images in a form; their bytes lie in the body.
absl::StatusOr<codec::RgbdImages> images_of(const FileRequest& request, std::string_view body) {
  std::vector<FieldViolation> faults;
  auto parts = parse_form(request.content_type, body);
  if (!parts.ok()) return wire::with_reason(parts.status(), wire::ErrorReason::kMalformedPayload);
  codec::RgbdImages images;
  for (const FormPart& part : *parts) {
    std::string_view* const image = part.name == "depth"   ? &images.depth
                                    : part.name == "color" ? &images.color
                                                           : nullptr;
    if (image == nullptr) {
      faults.push_back({part.name.substr(0, 64), is_segment_parameter(part.name)
                                                     ? "is a parameter of the query, and no part of the form"
                                                     : "is no part of the form, which has depth and color"});
    } else if (!image->empty()) {
      faults.push_back({part.name, "is given twice"});
    } else {
      *image = part.content;
    }
  }
  const SegmentParameters& parameters = request.parameters;
  if (images.depth.empty()) faults.push_back({"depth", "is missing: the form needs a depth image"});
  if (!parameters.intrinsics) faults.push_back({"intrinsics", "is missing: it must be FX,FY,CX,CY in pixels"});
  if (parameters.color_intrinsics && images.color.empty()) {
    faults.push_back({"rgb_intrinsics", "does not go without the part color of the form"});
  }
  if (parameters.read.view) faults.push_back({"view", "does not go with images, which are seen from the camera"});
  if (parameters.read.unit) {
    faults.push_back({"unit", "does not go with images: depth_scale tells their unit"});
  }
  RETURN_IF_ERROR(wire::invalid_fields(faults));
  images.intrinsics = *parameters.intrinsics;
  images.color_intrinsics = parameters.color_intrinsics;
  images.depth_scale =
      parameters.depth_scale.value_or(codec::depth_format(images.depth).value_or(codec::DepthFormat{}).usual_scale());
  return images;
}

/// INVALID_FIELD for parameters that are for images, if there are none.
absl::Status check_without_images(const SegmentParameters& parameters) {
  constexpr const char* kText = "is for images, which come in a form with the parts depth and color";
  std::vector<FieldViolation> faults;
  if (parameters.intrinsics) faults.push_back({"intrinsics", kText});
  if (parameters.color_intrinsics) faults.push_back({"rgb_intrinsics", kText});
  if (parameters.depth_scale) faults.push_back({"depth_scale", kText});
  return wire::invalid_fields(faults);
}

class FileUpload final : public FrameUpload {
 public:
  FileUpload(std::shared_ptr<HttpFrame> frame, FileRequest request, const FrameResolver& resolver, DressAnswer dress)
      : FrameUpload(std::move(frame), error_answer, std::move(dress)),
        request_(std::move(request)),
        resolver_(resolver) {}

 private:
  std::uint64_t most_bytes() const override { return request_.max_body_bytes; }
  Limit limit() const override { return {"max_body_bytes", "the body of the request has"}; }

  absl::StatusOr<HttpFrame::Order> read(std::string body) override {
    HttpFrame::Order order;
    wire::ParsedRequest parsed = request_.parameters.request;
    order.settings = resolver_.resolve_file(std::move(parsed), body.size(), frame().arrival(), frame().deadline());
    order.settings.answer_bytes_per_point = bytes_per_point(request_.form);
    const auto kept = std::make_shared<const std::string>(std::move(body));
    if (request_.content_type.starts_with(kForm)) {
      frame().record().payload_kind = v1::PAYLOAD_KIND_RGBD;
      ASSIGN_OR_RETURN(const codec::RgbdImages images, images_of(request_, *kept));
      order.decode = [kept, images](const codec::DecodeLimits& limits, const StopToken& stop) {
        return decoded(codec::decode_rgbd(images, limits, stop));
      };
    } else {
      RETURN_IF_ERROR(check_without_images(request_.parameters));
      const auto bytes = std::as_bytes(std::span(*kept));
      if (codec::is_taken_as_pcd(bytes)) frame().record().payload_kind = v1::PAYLOAD_KIND_PCD_FILE;
      order.decode = [kept, bytes, read = request_.parameters.read](const codec::DecodeLimits& limits,
                                                                    const StopToken& stop) {
        return decoded(codec::decode_cloud(bytes, limits, read, stop));
      };
    }
    AnswerContent content{.outputs = request_.parameters.request.outputs,
                          .prompts = request_.parameters.request.prompts,
                          .name = request_.parameters.name};
    order.encode = [form = request_.form, content = std::move(content)](wire::Result& result, const CloudView& cloud) {
      return answer_of(form, content, result, cloud);
    };
    return order;
  }

  static absl::StatusOr<wire::DecodedCloud> decoded(absl::StatusOr<codec::LabeledCloud> cloud) {
    ASSIGN_OR_RETURN(codec::LabeledCloud labeled, wire::with_decode_reason(std::move(cloud)));
    return wire::decoded_cloud(std::move(labeled));
  }

  const FileRequest request_;
  const FrameResolver& resolver_;
};

class ConnectUpload final : public FrameUpload {
 public:
  ConnectUpload(std::shared_ptr<HttpFrame> frame, ConnectCodec codec, const FrameResolver& resolver, DressAnswer dress)
      : FrameUpload(std::move(frame), connect_error_answer, std::move(dress)), codec_(codec), resolver_(resolver) {}

 private:
  std::uint64_t most_bytes() const override {
    // In JSON bytes are base64.
    return codec_ == ConnectCodec::kJson ? wire::kMaxRequestBytes / 3 * 4 : wire::kMaxRequestBytes;
  }
  Limit limit() const override { return {"max_message_bytes", "the request has"}; }
  std::uint64_t memory_of(std::uint64_t bytes) const override { return parsing_bytes(codec_, bytes); }

  absl::StatusOr<HttpFrame::Order> read(std::string body) override {
    const auto request = std::make_shared<v1::SegmentRequest>();
    RETURN_IF_ERROR(parse_connect(codec_, std::move(body), "SegmentRequest", *request));
    RETURN_IF_ERROR(frame().reserve(request->ByteSizeLong()));
    frame().record().request_id = request->request_id();
    frame().record().payload_kind = wire::kind_of(request->cloud());
    HttpFrame::Order order;
    ASSIGN_OR_RETURN(order.settings, resolver_.resolve_call(*request, frame().arrival(), frame().deadline()));
    if (codec_ == ConnectCodec::kJson) order.settings.answer_bytes_per_point = kJsonBytesPerPoint;
    order.decode = [request](const codec::DecodeLimits& limits, const StopToken& stop) {
      return wire::decode_cloud(request->cloud(), limits, stop);
    };
    order.encode = [request, codec = codec_, outputs = order.settings.outputs, arrival = frame().arrival()](
                       const wire::Result& result, const CloudView&) {
      return answer(*request, codec, outputs, arrival, result);
    };
    return order;
  }

  static absl::StatusOr<HttpAnswer> answer(const v1::SegmentRequest& request, ConnectCodec codec,
                                           const wire::Outputs& outputs, HttpFrame::Time arrival,
                                           const wire::Result& result) {
    const Clock::time_point start = Clock::now();
    v1::SegmentResponse response;
    response.set_request_id(request.request_id());
    response.set_frame_id(request.frame_id());
    if (request.has_stamp()) *response.mutable_stamp() = request.stamp();
    ASSIGN_OR_RETURN(*response.mutable_result(), wire::to_message(result, outputs));
    const Clock::time_point done = Clock::now();
    wire::set_final_timings(*response.mutable_result(), milliseconds(done - start), milliseconds(done - arrival));
    return connect_answer(codec, response);
  }

  /// The arrays in base64, and the text, which may double while it grows.
  static constexpr std::uint64_t kJsonBytesPerPoint = 40;

  const ConnectCodec codec_;
  const FrameResolver& resolver_;
};

}  // namespace

std::shared_ptr<HttpUpload> file_upload(std::shared_ptr<HttpFrame> frame, FileRequest request,
                                        const FrameResolver& resolver, DressAnswer dress) {
  return std::make_shared<FileUpload>(std::move(frame), std::move(request), resolver, std::move(dress));
}

std::shared_ptr<HttpUpload> connect_upload(std::shared_ptr<HttpFrame> frame, ConnectCodec codec,
                                           const FrameResolver& resolver, DressAnswer dress) {
  return std::make_shared<ConnectUpload>(std::move(frame), codec, resolver, std::move(dress));
}

}  // namespace segserve::server
