// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "server/frames/frame_resolver.hpp"
#include "server/http/connect_call.hpp"
#include "server/http/frame_answer.hpp"
#include "server/http/http_frame.hpp"
#include "server/http/http_handler.hpp"
#include "server/http/segment_parameters.hpp"

// Requests that bring a frame.
namespace segserve::server {

/// Adds to an answer what every answer of the entrance has.
using DressAnswer = std::function<HttpAnswer(HttpAnswer)>;

/// A request by POST /v1/segment.
struct FileRequest {
  SegmentParameters parameters;
  AnswerForm form = AnswerForm::kJson;
  std::string content_type;  ///< of the body: that of a form, or anything else for the bytes of a file
  std::uint64_t max_body_bytes = 0;
};

/// The upload of a file, or of a form with the parts `depth` and `color`. `resolver` must outlive it.
std::shared_ptr<HttpUpload> file_upload(std::shared_ptr<HttpFrame> frame, FileRequest request,
                                        const FrameResolver& resolver, DressAnswer dress);

/// The upload of a SegmentRequest of the protocol Connect. `resolver` must outlive it.
std::shared_ptr<HttpUpload> connect_upload(std::shared_ptr<HttpFrame> frame, ConnectCodec codec,
                                           const FrameResolver& resolver, DressAnswer dress);

}  // namespace segserve::server
